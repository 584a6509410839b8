//! Thread that sends force feedback to the wheel. In: the drive loop's last [`ForceInput`], the wheel's angle from the
//! reading thread. Out: levels for the device, only when they change. If the drive loop stalls, pauses or ends, the
//! force is zero within 100 ms. If the program is killed, the kernel removes the effect when it closes the device's
//! file (tested in a real kernel by `scripts/wheel-vm`).

use super::{
    clock::TimeStamp,
    force::{ForceInput, ForceModel},
    profile::WheelProfile,
};
use crate::controls::{STEERING_LOCK_RAD, STEERING_RATIO};
use std::{
    io,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};

/// Period of the thread: 167 Hz. The wheel's driver waits for the USB frame in each write.
pub const PERIOD: Duration = Duration::from_millis(6);

/// Receiver of force levels: a wheel, or a recorder in tests.
pub trait ForceDevice: Send {
    /// Sets the constant level, held until the next call.
    ///
    /// # Errors
    /// The device is gone or refuses the level.
    fn set(&mut self, level: i16) -> io::Result<()>;

    /// Notes that the thread has made a turn, with or without a new level; for measurements of its period.
    fn turned(&mut self) {}

    /// Ends the force and sets the device's own centring to the profile's strength.
    fn end(&mut self);
}

/// Angle that one thread writes and another reads, radians.
#[derive(Debug, Default)]
pub struct SharedAngle(AtomicU64);

impl SharedAngle {
    /// Sets the angle, positive to the left.
    pub fn set(&self, rad: f64) {
        self.0.store(rad.to_bits(), Ordering::Relaxed);
    }

    /// Returns the last angle, 0 before the first.
    pub fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

/// Torques that were sent since the drive loop last asked, and the hands' torque.
#[derive(Debug, Default)]
struct SentTorques {
    sum_nm: f64,
    count: u32,
    last_nm: f64,
    /// Estimated torque of the hands, N m; `None` before the first turn and after the last.
    hand_nm: Option<f64>,
}

impl SentTorques {
    fn add(&mut self, torque_nm: f64, hand_nm: Option<f64>) {
        self.hand_nm = hand_nm;
        self.sum_nm += torque_nm;
        self.count += 1;
        self.last_nm = torque_nm;
    }

    /// Returns the mean and begins anew; without a torque since then, the last one is still in force.
    fn take_mean_nm(&mut self) -> f64 {
        let mean_nm = if self.count == 0 { self.last_nm } else { self.sum_nm / f64::from(self.count) };
        *self = Self { last_nm: self.last_nm, hand_nm: self.hand_nm, ..Self::default() };
        mean_nm
    }
}

/// Exchange between the drive loop and the force thread: the last input with its time, the torques sent, and the
/// request to stop.
#[derive(Debug, Default)]
struct LoggedMessage {
    force_input: Mutex<(ForceInput, TimeStamp)>,
    torques: Mutex<SentTorques>,
    stop: AtomicBool,
}

impl LoggedMessage {
    fn torques(&self) -> MutexGuard<'_, SentTorques> {
        self.torques.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Handle of the running thread; dropping it ends the thread.
pub struct ForceThread {
    shared: Arc<LoggedMessage>,
    thread: Option<JoinHandle<()>>,
}

/// Body of the force thread, without its timing.
pub struct ForceLoop {
    device: Box<dyn ForceDevice>,
    model: ForceModel,
    left_is_low: bool,
    /// Turn of this wheel for a turn of the ego's.
    per_car_rad: f64,
    sent: Option<i16>,
    last: Option<TimeStamp>,
}

impl ForceLoop {
    /// Creates the loop for a wheel; sends nothing yet.
    pub fn new(device: Box<dyn ForceDevice>, profile: &WheelProfile) -> Self {
        let per_car_rad = profile.steering.ratio / f64::from(STEERING_RATIO);
        let lock_rad = f64::from(STEERING_LOCK_RAD) * per_car_rad;
        let end_rad = (profile.steering.range_deg / 2.0).to_radians().min(lock_rad);
        let model = ForceModel::new(&profile.force, end_rad);
        let left_is_low = (profile.steering.left < profile.steering.right) != profile.force.invert;
        Self { device, model, left_is_low, per_car_rad, sent: None, last: None }
    }

    /// Computes the force at time `now`, for the angle of this wheel, and sends its level if it has changed. Returns the torque, N m.
    ///
    /// # Errors
    /// The device is gone or refuses the level.
    pub fn turn(
        &mut self,
        now: TimeStamp,
        wheel_rad: f64,
        force_input: &ForceInput,
        input_at: TimeStamp,
    ) -> io::Result<f64> {
        self.device.turned();
        let dt_s = self.last.map_or(PERIOD, |last| last.until(now)).as_secs_f64().clamp(1e-4, 0.05);
        self.last = Some(now);
        let held_rad = force_input.held_rad.map(|rad| rad * self.per_car_rad);
        let force_input = ForceInput { held_rad, ..*force_input };
        let torque_nm = self.model.step(dt_s, wheel_rad, &force_input, input_at.until(now).as_secs_f64());
        let level = self.model.level(torque_nm, self.left_is_low);
        if self.sent != Some(level) {
            self.device.set(level)?;
            self.sent = Some(level);
        }
        Ok(torque_nm)
    }
}

impl Drop for ForceLoop {
    fn drop(&mut self) {
        self.device.end();
    }
}

impl ForceThread {
    /// Starts the thread; `angle` is the wheel's angle, written by the reading thread.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub fn start(mut force: ForceLoop, angle: Arc<SharedAngle>) -> io::Result<Self> {
        let shared = Arc::new(LoggedMessage::default());
        let of_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name("force".into()).spawn(move || {
            hurry();
            let mut next = TimeStamp::now();
            while !of_thread.stop.load(Ordering::Relaxed) {
                let (force_input, at) = *of_thread.force_input.lock().unwrap_or_else(PoisonError::into_inner);
                match force.turn(TimeStamp::now(), angle.get(), &force_input, at) {
                    Ok(torque_nm) => of_thread.torques().add(torque_nm, Some(force.model.hand_torque_nm())),
                    Err(error) => {
                        // ENODEV means an unplugged wheel, which the reading thread reports.
                        log::warn!("the wheel accepts no more force ({error}); the drive continues without force");
                        break;
                    }
                }
                let now = TimeStamp::now();
                next = turn_after(next, now);
                std::thread::sleep(now.until(next));
            }
            of_thread.torques().add(0.0, None);
        })?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Sets the inputs of the force model.
    pub fn set_input(&self, force_input: ForceInput) {
        *self.shared.force_input.lock().unwrap_or_else(PoisonError::into_inner) = (force_input, TimeStamp::now());
    }

    /// Returns the mean torque that was sent since the last call, N m, positive to the left. The last value alone would
    /// miss the pushes on a slow display: the force fades out before each late picture.
    pub fn take_torque_nm(&self) -> f64 {
        self.shared.torques().take_mean_nm()
    }

    /// Returns the estimated torque of the hands, N m, positive to the left; `None` while no force is sent.
    pub fn hand_torque_nm(&self) -> Option<f64> {
        self.shared.torques().hand_nm
    }
}

/// Returns the first time after `now` that is a whole number of periods after `planned`. A turn that came too late is
/// therefore not followed by an extra one.
fn turn_after(planned: TimeStamp, now: TimeStamp) -> TimeStamp {
    let mut next = planned;
    while next <= now {
        next.0 += PERIOD;
    }
    next
}

/// Raises the priority of this thread, so that software rendering does not delay the force. It asks for real-time
/// scheduling (a turn takes microseconds), or else for a better nice value. Without permission for either, the priority
/// stays as it is; `rtprio` in /etc/security/limits.conf permits real time. Returns true for real time.
fn hurry() -> bool {
    #[cfg(target_os = "linux")]
    {
        /// Real-time priority above all ordinary threads, below sound servers and the kernel's own threads.
        const PRIORITY: nix::libc::c_int = 5;
        const NICE: nix::libc::c_int = -12;
        let asked = nix::libc::sched_param { sched_priority: PRIORITY };
        // SAFETY: the kernel reads one struct and numbers; 0 is the calling thread in both calls.
        unsafe {
            let real_time = nix::libc::sched_setscheduler(0, nix::libc::SCHED_RR, &raw const asked) == 0;
            if !real_time {
                nix::libc::setpriority(nix::libc::PRIO_PROCESS, 0, NICE);
            }
            real_time
        }
    }
    #[cfg(not(target_os = "linux"))]
    false
}

/// Checks whether a thread of this user may run in real time, by trying it in a short-lived thread.
pub fn may_hurry() -> bool {
    std::thread::spawn(hurry).join().unwrap_or(false)
}

impl Drop for ForceThread {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use nix::libc;

    #[test]
    fn a_late_turn_is_left_out_and_the_pace_is_kept() {
        // Turns are due at 0, 6, 12, ... ms.
        for (planned_us, now_us, expected_us) in [
            (0, 0, 6_000),
            (6_000, 100, 6_000),
            (6_000, 5_999, 6_000),
            (6_000, 6_000, 12_000),
            (6_000, 7_500, 12_000),
            (6_000, 50_000, 54_000),
        ] {
            let [planned, now, expected] =
                [planned_us, now_us, expected_us].map(|us| TimeStamp(Duration::from_micros(us)));
            assert_eq!(turn_after(planned, now), expected, "planned for {planned_us} us, asked at {now_us} us");
        }
    }

    #[test]
    fn the_torque_of_a_frame_is_the_mean_since_the_frame_before() {
        let mut torques = SentTorques::default();
        assert_eq!(torques.take_mean_nm(), 0.0);
        // A push that has faded out when the next picture comes.
        for torque_nm in [-0.5, -0.7, -0.3, 0.0, 0.0] {
            torques.add(torque_nm, None);
        }
        assert!((torques.take_mean_nm() + 0.3).abs() < 1e-12);
        torques.add(-0.2, Some(0.7));
        assert_eq!(torques.take_mean_nm(), -0.2);
        assert_eq!(torques.take_mean_nm(), -0.2, "the level is held until the next one");
        assert_eq!(torques.hand_nm, Some(0.7));
    }

    #[test]
    fn a_thread_reports_real_time_only_if_the_kernel_scheduled_it_so() {
        let (is_real_time, policy, nice) = std::thread::spawn(|| {
            let is_real_time = hurry();
            // SAFETY: numbers only; 0 is the calling thread.
            unsafe { (is_real_time, libc::sched_getscheduler(0), libc::getpriority(libc::PRIO_PROCESS, 0)) }
        })
        .join()
        .unwrap();
        assert_eq!(is_real_time, policy == libc::SCHED_RR);
        assert!(is_real_time || policy == libc::SCHED_OTHER, "{policy}");
        // A user who may lower the nice value has it lowered then.
        assert!(is_real_time || nice == -12 || !may_be_nicer(), "{nice}");
        assert_eq!(may_hurry(), is_real_time, "who asks for another thread hears the same");
    }

    /// Checks whether this user's threads may have the nice value -12, by trying it in a short-lived thread.
    fn may_be_nicer() -> bool {
        // SAFETY: numbers only; 0 is the calling thread.
        std::thread::spawn(|| unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, -12) } == 0).join().unwrap()
    }
}
