//! Confinement of this program's streams to one network interface. In: the setting, and a call that opens liblsl's
//! sockets. Out: the sockets, which ignore every other interface. liblsl binds them to all interfaces, and no setting
//! of its own changes that. A kernel filter (BPF) drops packets from other interfaces.

use super::LslError;

/// Network interface on which this program's streams can be received.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OutletInterface {
    /// Loopback, for programs on this computer only.
    Loopback,
    /// Every network of this computer.
    All,
    /// Loopback and the network of this interface.
    Named(String),
}

/// Value of the setting for [`OutletInterface::Loopback`].
pub const LOOPBACK: &str = "loopback";
/// Value of the setting for [`OutletInterface::All`].
pub const ALL: &str = "all";

impl OutletInterface {
    /// Parses the setting: `loopback`, `all`, or the name of an interface.
    pub fn of(setting: &str) -> Self {
        match setting {
            LOOPBACK => Self::Loopback,
            ALL => Self::All,
            name => Self::Named(name.into()),
        }
    }

    /// Checks that the interface exists and that streams can be confined to it.
    ///
    /// # Errors
    /// There is no such interface, and the error lists those that exist; or the system does not support it, with the
    /// remedy.
    pub fn check(&self) -> Result<(), LslError> {
        if *self == Self::All { Ok(()) } else { system::allowed(self).map(drop) }
    }

    /// Calls `open`, then makes every socket that it opened ignore other interfaces. Connections made in between are
    /// closed.
    ///
    /// # Errors
    /// An error of `open`, a missing interface, or a refusal of the system.
    pub(super) fn confine<T>(&self, open: impl FnOnce() -> Result<T, LslError>) -> Result<T, LslError> {
        if *self == Self::All { open() } else { system::confine(&system::allowed(self)?, open) }
    }
}

#[cfg(target_os = "linux")]
mod system {
    use super::{LslError, OutletInterface};
    use nix::libc;
    use std::{
        collections::BTreeSet,
        fs, io,
        path::PathBuf,
        sync::{Mutex, PoisonError},
    };

    /// System folder with an entry for each interface.
    const INTERFACES: &str = "/sys/class/net";
    /// Name of the loopback interface on Linux.
    const LO: &str = "lo";
    /// Offsets at which a filter reads a packet's interface index and type (linux/filter.h).
    const INTERFACE_AT: u32 = (-0x1000_i32 + 8) as u32;
    const KIND_AT: u32 = (-0x1000_i32 + 4) as u32;
    /// Type of a multicast packet that this computer sent and receives itself (linux/if_packet.h).
    const LOOPED_BACK: u32 = 5;

    /// Lock for one confinement at a time, because the sockets are identified as the newly opened ones.
    static OPENING: Mutex<()> = Mutex::new(());

    /// Returns the indices of the interfaces that may be received.
    pub fn allowed(interface: &OutletInterface) -> Result<Vec<u32>, LslError> {
        let names = match interface {
            OutletInterface::Named(name) => vec![LO, name.as_str()],
            _ => vec![LO],
        };
        names.into_iter().map(number).collect()
    }

    fn number(name: &str) -> Result<u32, LslError> {
        let plain = !name.is_empty() && !name.contains(['/', '.']);
        let text = plain.then(|| fs::read_to_string(format!("{INTERFACES}/{name}/ifindex")).ok()).flatten();
        text.and_then(|text| text.trim().parse().ok()).ok_or_else(|| {
            let entries = fs::read_dir(INTERFACES).into_iter().flatten().flatten();
            let mut known: Vec<String> =
                entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
            known.sort();
            LslError::NoInterface { name: name.into(), known: known.join(", ") }
        })
    }

    pub fn confine<T>(allowed: &[u32], open: impl FnOnce() -> Result<T, LslError>) -> Result<T, LslError> {
        let _one = OPENING.lock().unwrap_or_else(PoisonError::into_inner);
        let refused = |why: io::Error| LslError::Refused {
            what: "to keep its streams on one interface".into(),
            why: why.to_string(),
        };
        let before: BTreeSet<PathBuf> = open_files().map_err(refused)?.into_iter().map(|(_, what)| what).collect();
        let opened = open()?;
        let new = open_files().map_err(refused)?.into_iter().filter(|(_, what)| !before.contains(what));
        let sockets: Vec<(i32, InetSocket)> = new.filter_map(|(file, _)| Some((file, InetSocket::of(file)?))).collect();
        for (file, _) in sockets.iter().filter(|(_, socket)| !socket.is_connected) {
            filter(*file, allowed).map_err(refused)?;
        }
        let is_served = |port: u16| sockets.iter().any(|(_, other)| !other.is_connected && other.port == port);
        for (file, _) in sockets.iter().filter(|(_, socket)| socket.is_connected && is_served(socket.port)) {
            // SAFETY: uses no memory; at worst the file is no longer open.
            unsafe { libc::shutdown(*file, libc::SHUT_RDWR) };
        }
        Ok(opened)
    }

    /// Returns the numbers of this process's open files with their link targets. A socket's target contains a number
    /// unique to the socket.
    fn open_files() -> io::Result<Vec<(i32, PathBuf)>> {
        let entries = fs::read_dir("/proc/self/fd")?.flatten();
        let file =
            |entry: fs::DirEntry| Some((entry.file_name().to_str()?.parse().ok()?, fs::read_link(entry.path()).ok()?));
        Ok(entries.filter_map(file).collect())
    }

    /// A TCP or UDP socket.
    pub struct InetSocket {
        pub port: u16,
        /// True if the socket has a peer.
        pub is_connected: bool,
    }

    impl InetSocket {
        /// Returns the socket of a file of this process; `None` for another kind of file, and for a socket without a
        /// port.
        pub fn of(file: i32) -> Option<Self> {
            type Ask = unsafe extern "C" fn(i32, *mut libc::sockaddr, *mut libc::socklen_t) -> i32;
            let address = |ask: Ask| {
                // SAFETY: all zeros is a valid address without a family, and the system writes no more than its size.
                unsafe {
                    let mut address: libc::sockaddr_in6 = std::mem::zeroed();
                    let mut size = size_of_val(&address) as libc::socklen_t;
                    (ask(file, (&raw mut address).cast(), &mut size) == 0).then_some(address)
                }
            };
            let own = address(libc::getsockname)?;
            let is_inet = [libc::AF_INET, libc::AF_INET6].contains(&i32::from(own.sin6_family));
            // The port is at the same offset in addresses of both families.
            let port = u16::from_be(own.sin6_port);
            let is_connected = address(libc::getpeername).is_some();
            (is_inet && port != 0).then_some(Self { port, is_connected })
        }
    }

    /// Limits a socket to packets from these interfaces and to multicast packets that this computer sent itself.
    pub fn filter(file: i32, allowed: &[u32]) -> io::Result<()> {
        let load = |at: u32| libc::sock_filter { code: 0x20, jt: 0, jf: 0, k: at };
        let equals = |value: u32, to_end: usize| libc::sock_filter { code: 0x15, jt: to_end as u8, jf: 0, k: value };
        let end = |bytes: u32| libc::sock_filter { code: 0x06, jt: 0, jf: 0, k: bytes };
        let mut program = vec![load(INTERFACE_AT)];
        // On a match, jump to the last instruction, which accepts the packet.
        program.extend(allowed.iter().enumerate().map(|(k, number)| equals(*number, allowed.len() - k + 2)));
        program.extend([load(KIND_AT), equals(LOOPED_BACK, 1), end(0), end(u32::MAX)]);
        let wanted = libc::sock_fprog { len: program.len() as u16, filter: program.as_mut_ptr() };
        // SAFETY: the program is valid for the call, which copies it.
        let done = unsafe {
            let size = size_of_val(&wanted) as libc::socklen_t;
            libc::setsockopt(file, libc::SOL_SOCKET, libc::SO_ATTACH_FILTER, (&raw const wanted).cast(), size)
        };
        if done == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
    }

    #[cfg(test)]
    mod tests {
        use super::*;
        use std::{
            net::{TcpListener, TcpStream, UdpSocket},
            os::fd::AsRawFd,
            time::Duration,
        };

        /// Checks whether sockets with this filter receive packets over the loopback, by TCP and by UDP.
        fn hears(allowed: &[u32]) -> [bool; 2] {
            // Not while another test confines newly opened sockets.
            let _one = OPENING.lock().unwrap_or_else(PoisonError::into_inner);
            let (listener, datagrams) =
                (TcpListener::bind("0.0.0.0:0").unwrap(), UdpSocket::bind("0.0.0.0:0").unwrap());
            filter(listener.as_raw_fd(), allowed).unwrap();
            filter(datagrams.as_raw_fd(), allowed).unwrap();
            let port = listener.local_addr().unwrap().port();
            let wait = Duration::from_millis(200);
            let connected = TcpStream::connect_timeout(&([127, 0, 0, 1], port).into(), wait).is_ok();
            let to = datagrams.local_addr().unwrap().port();
            UdpSocket::bind("127.0.0.1:0").unwrap().send_to(b"x", ("127.0.0.1", to)).unwrap();
            datagrams.set_read_timeout(Some(wait)).unwrap();
            [connected, datagrams.recv(&mut [0; 8]).is_ok()]
        }

        #[test]
        fn a_filter_accepts_packets_of_its_interfaces_only() {
            let lo = number(LO).unwrap();
            assert_eq!(hears(&[lo]), [true, true]);
            assert_eq!(hears(&[9999, lo]), [true, true]);
            assert_eq!(hears(&[lo, 9999]), [true, true]);
            assert_eq!(hears(&[9999]), [false, false]);
            assert_eq!(hears(&[9998, 9999]), [false, false]);
        }

        #[test]
        fn only_sockets_opened_by_the_call_are_confined() {
            let before = TcpListener::bind("0.0.0.0:0").unwrap();
            let opened = confine(&[9999], || Ok(TcpListener::bind("0.0.0.0:0").unwrap())).unwrap();
            let reached = |listener: &TcpListener| {
                let port = listener.local_addr().unwrap().port();
                TcpStream::connect_timeout(&([127, 0, 0, 1], port).into(), Duration::from_millis(200)).is_ok()
            };
            assert!(reached(&before) && !reached(&opened));
        }

        #[test]
        fn a_missing_interface_is_named_with_the_existing_ones() {
            let message = OutletInterface::of("eth77").check().unwrap_err().to_string();
            assert!(
                message.starts_with("there is no network interface \"eth77\"; allowed: loopback, all, ")
                    && message.contains("lo"),
                "{message}"
            );
            assert!(OutletInterface::of("../lo").check().is_err());
            assert!(OutletInterface::of("loopback").check().is_ok() && OutletInterface::of("lo").check().is_ok());
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    use super::{LslError, OutletInterface};

    pub fn allowed(_: &OutletInterface) -> Result<Vec<u32>, LslError> {
        Err(LslError::Refused {
            what: "to keep its streams on one interface".into(),
            why: "this system cannot; remedy: interface = \"all\" in [lsl], and a firewall for the rest".into(),
        })
    }

    pub fn confine<T>(_: &[u32], open: impl FnOnce() -> Result<T, LslError>) -> Result<T, LslError> {
        open()
    }
}
