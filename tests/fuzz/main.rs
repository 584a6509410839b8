//! Tests that no input of any reader causes a panic, an abort, or the use of more than 256 MiB. In: good inputs with changes (`mutate`),
//! for every reader (`readers`). Out: for each reader the number of inputs, the time, the number of accepted inputs, and the largest memory
//! (`memory`).
//!
//! In a run of all tests each reader gets a fixed number of inputs, always the same ones, half a minute in all. `scripts/fuzz` sets
//! `CODRIVE_FUZZ_SECONDS` (and `CODRIVE_FUZZ_SEED`, `CODRIVE_FUZZ_READER`) and continues for that time. An input that breaks a reader is
//! kept in `target/tmp/fuzz/`; after an abort, the input that was being read is there.

mod good_texts;
mod large_network;
mod memory;
mod mutate;
mod readers;
mod scenes;

use codrive::rng;
use memory::MOST;
use readers::Reader;
use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard},
    time::{Duration, Instant},
};

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;

/// Time limit for one input, a hundred times the time of the slowest good one on a busy machine.
const LONGEST: Duration = Duration::from_secs(30);

/// Place and message of the last panic.
static LAST_PANIC: Mutex<String> = Mutex::new(String::new());

fn number(name: &str) -> Option<u64> {
    std::env::var(name)
        .ok()
        .map(|text| text.parse().unwrap_or_else(|_| panic!("{name} is {text:?}; allowed: a number")))
}

/// Locks out the other tests, as memory is counted for the whole program.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Statistics of one reader.
#[derive(Default)]
struct Account {
    inputs: usize,
    accepted: usize,
    largest: usize,
    peak: usize,
    slowest: Duration,
    faults: Vec<String>,
}

#[expect(clippy::disallowed_methods, reason = "how long a reader takes is what is asked")]
fn now() -> Instant {
    Instant::now()
}

/// Feeds a reader inputs until `enough` returns true for their number.
fn feed(reader: &Reader, seed: u64, kept: &Path, enough: impl Fn(usize) -> bool) -> Account {
    let mut stream = rng::stream(seed, reader.name);
    let mut account = Account::default();
    let current = kept.join(format!("{}.now", reader.name));
    let by_hand = number("CODRIVE_FUZZ_SECONDS").is_some();
    while !enough(account.inputs) && account.faults.len() < 10 {
        // The good inputs first, unchanged.
        let input = match reader.good.get(account.inputs) {
            Some(good) => good.clone(),
            None => {
                let good = reader.good[stream.index(reader.good.len())].clone();
                let other = stream.index(reader.good.len());
                (reader.change)(&mut stream, good, &reader.good[other])
            }
        };
        if by_hand {
            fs::write(&current, &input).unwrap();
        }
        let (held, begun) = (memory::begin(), now());
        let read = catch_unwind(AssertUnwindSafe(|| (reader.read)(&input)));
        let (took, (largest, peak)) = (begun.elapsed(), memory::since(held));
        account.inputs += 1;
        account.accepted += usize::from(matches!(read, Ok(true)));
        account.largest = account.largest.max(largest);
        account.peak = account.peak.max(peak);
        account.slowest = account.slowest.max(took);
        let fault = match read {
            Err(_) => LAST_PANIC.lock().unwrap().clone(),
            Ok(_) if peak > MOST => format!("took {} MiB, {} of them at once", peak >> 20, largest >> 20),
            Ok(_) if took > LONGEST => format!("took {took:?}"),
            Ok(_) => continue,
        };
        let file = kept.join(format!("{}-{seed}-{}", reader.name, account.inputs));
        fs::write(&file, &input).unwrap();
        account.faults.push(format!("{} ({}): {fault}", reader.name, file.display()));
    }
    let _ = fs::remove_file(current);
    account
}

#[test]
fn no_input_causes_a_panic_an_abort_or_much_memory() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let kept = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("fuzz");
    fs::create_dir_all(&kept).unwrap();
    let readers = readers::all(folder.path());
    std::panic::set_hook(Box::new(|info| {
        *LAST_PANIC.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = info.to_string();
    }));
    let (seconds, first) = (number("CODRIVE_FUZZ_SECONDS"), number("CODRIVE_FUZZ_SEED").unwrap_or(1));
    let only = std::env::var("CODRIVE_FUZZ_READER").ok().filter(|name| !name.is_empty());
    let chosen: Vec<&Reader> =
        readers.iter().filter(|reader| only.as_ref().is_none_or(|name| *name == reader.name)).collect();
    println!("reader           inputs   inputs/s  accepted  largest request  most held  slowest");
    let mut all = Account::default();
    let begun = now();
    for reader in &chosen {
        let start = now();
        let account = match seconds {
            None => feed(reader, first, &kept, |n| n >= reader.share),
            Some(seconds) => {
                let part = Duration::from_secs(seconds) / chosen.len() as u32;
                feed(reader, first, &kept, |_| start.elapsed() > part)
            }
        };
        println!(
            "{:<14} {:>8} {:>10.0} {:>8.1} % {:>12.1} MiB {:>6.1} MiB {:>7.3} s{}",
            reader.name,
            account.inputs,
            account.inputs as f64 / start.elapsed().as_secs_f64(),
            100.0 * account.accepted as f64 / account.inputs as f64,
            account.largest as f64 / 1_048_576.0,
            account.peak as f64 / 1_048_576.0,
            account.slowest.as_secs_f64(),
            if account.faults.is_empty() { String::new() } else { format!("  {} FAULTS", account.faults.len()) }
        );
        all.inputs += account.inputs;
        all.peak = all.peak.max(account.peak);
        all.faults.extend(account.faults);
        if account.accepted == 0 {
            all.faults.push(format!("{}: not even a good input is accepted", reader.name));
        }
    }
    drop(std::panic::take_hook());
    println!(
        "{} inputs in {:.0} s, {} faults, at most {:.1} MiB held for one",
        all.inputs,
        begun.elapsed().as_secs_f64(),
        all.faults.len(),
        all.peak as f64 / 1_048_576.0
    );
    assert!(all.faults.is_empty(), "{}", all.faults.join("\n"));
}
