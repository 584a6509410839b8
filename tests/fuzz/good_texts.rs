//! Good inputs of readers that no file of the repository is.

/// Drivers file as an analysis writes it.
pub const DRIVERS: &str = "format = \"codrive drivers 1\"\nstudy = \"A study\"\n\n[[driver]]\nparticipant = \"sub-P01\"\nreaction_s = 1.2\n\
                       error_mps = 0.3\nspeed_bias_mps = -0.1\ntime_gap_factor = 1.1\n\n[[driver]]\nspeed_bias_mps = 0.2\n";

/// Surroundings with all that is read of them.
pub const SURROUNDINGS: &str = "<additional>\n<poly id='1' type='building.house' height='6.5' shape='0,0 9,0 9,8 0,8 0,0'/>\n\
                         <poly id='2' type='building' shape='0,0,1 0,9,1 9,9,1'><param key='building:levels' value='3'/></poly>\n\
                         <poly id='3' type='landuse.forest' shape='0,0 9,0 9,8'/>\n<poly id='4' type='natural.tree_row' shape='0,0 90,0'/>\n\
                         <poi id='5' type='natural.tree' x='3' y='4'><param key='leaf_type' value='needleleaved'/></poi>\n\
                         <poi id='6' type='traffic_sign.DE:274-50' x='3' y='9' angle='90'/>\n</additional>\n";

/// Objects beside a road of every shape.
pub const OPEN_DRIVE_OBJECTS: &str = "<OpenDRIVE><road><planView><geometry s='0' x='1' y='2' hdg='0.3' length='40'><line/></geometry>\
    <geometry s='40' x='39' y='13' hdg='0.3' length='30'><arc curvature='0.02'/></geometry><geometry s='70' x='60' y='30' hdg='0.9' length='30'>\
    <spiral curvStart='0.02' curvEnd='0'/></geometry><geometry s='100' x='80' y='60' hdg='1' length='50'><paramPoly3 aU='0' bU='50' cU='0' dU='0' \
    aV='0' bV='0' cV='4' dV='1' pRange='normalized'/></geometry></planView><objects><object type='building' s='20' t='-9' length='9' width='7' \
    height='6' hdg='0.2'/><object type='building' s='60' t='9'><outline><cornerLocal u='0' v='0' height='4'/><cornerLocal u='9' v='0'/>\
    <cornerRoad s='70' t='20'/></outline></object><object type='tree' s='0' t='5'><repeat s='50' length='60' distance='9' tStart='5' tEnd='7'/>\
    </object><object type='vegetation' s='0' t='0'><repeat s='80' length='50' distance='0' tStart='-6' tEnd='-5'/></object></objects><signals><signal s='30' t='-4' orientation='+' dynamic='no' country='DE' type='274' value='50'/></signals></road>\
    </OpenDRIVE>";

/// Demand with every kind of traffic.
pub const PERSONS: &[u8] = b"<routes>\n<vTypeDistribution id='d'><vType id='t' probability='1'><carFollowing-IDM tau='1'/></vType></vTypeDistribution>\n\
    <route id='r' edges='a b'/><interval begin='0' end='9'><flow id='f' period='exp(0.1)' route='r'/></interval>\n\
    <vehicle id='v' depart='1'><routeDistribution><route edges='a'/></routeDistribution><stop lane='a_0' duration='3'/></vehicle>\n\
    <person id='p' depart='2'><walk edges='a b'/><ride lines='x'/></person><containerFlow id='c' begin='3' number='2'>\
    <transport from='a' to='b'/></containerFlow></routes>\n";

/// Trajectories of two vehicles on a ring.
pub const TRAJECTORIES: &str = "time_s,vehicle,leader,speed_mps,gap_m\n0.0,a,b,4.0,45.0\n0.0,b,a,5.0,45.5\n0.5,a,b,4.5,45.2\n0.5,b,a,4.5,45.3\n\
                            1.0,a,b,5.0,45.4\n1.0,b,a,4.0,45.1\n";
