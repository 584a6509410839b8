#!/usr/bin/env bash
# Makes the networks of this folder with SUMO's netgenerate and netconvert; SUMO_HOME names where they are.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
bin=$SUMO_HOME/bin
: "${SUMO_HOME:?names the folder with bin/netconvert}"
quiet=(--no-warnings true --xml-validation never)
convert() { "$bin/netconvert" -n "$1.nod.xml" -e "$1.edg.xml" "${@:3}" -o "../$2.net.xml" "${quiet[@]}" >/dev/null; }
"$bin/netgenerate" --grid --grid.number 3 --grid.length 90 -L 2 --tls.guess --tls.default-type actuated -o ../grid-signals.net.xml "${quiet[@]}" >/dev/null
"$bin/netgenerate" --spider --spider.arm-number 4 --spider.circle-number 2 --spider.space-radius 60 -o ../spider.net.xml "${quiet[@]}" >/dev/null
"$bin/netgenerate" --rand --rand.iterations 9 --seed 3 --rand.max-distance 120 --rand.min-distance 60 -o ../random-3.net.xml "${quiet[@]}" >/dev/null
"$bin/netgenerate" --rand --rand.iterations 14 --seed 8 -L 2 --rand.max-distance 140 --rand.min-distance 70 --no-internal-links -o ../random-8.net.xml "${quiet[@]}" >/dev/null
convert ramps ramps --ramps.guess
convert roundabout roundabout --roundabouts.guess
convert hill hill --precision 4
convert town town -x town.con.xml --walkingareas --opposites.guess
convert town town-left --lefthand
convert oneway one-way
convert eight figure-eight -x eight.con.xml
convert track track
convert crossing crossing --no-turnarounds
convert allway allway --no-turnarounds
convert zebra zebra -x zebra.con.xml
convert bridge bridge
convert bicycles bicycles --no-turnarounds
# When they were made, by which version and with which options is no part of them.
for net in ../*.net.xml; do
    sed -i '/^<!-- generated on/,/^-->/d' "$net"
done
