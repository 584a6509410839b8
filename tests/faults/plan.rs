//! Plans of faults: the call that fails, and its kind of failure. In: text, as `write rows.blocks 2 ENOSPC; rename manifest.json 1 kill`.
//! Out: a plan, and its text again, which `preload.c` reads.

use std::{fmt, str::FromStr};

/// Fault at the `at`-th call of a kind on files with names that end in `name`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Kind of call, as `preload.c` names it.
    pub kind: String,
    /// End of the file's name; `*` for any file.
    pub name: String,
    /// Number of the call among the matching ones, from 1.
    pub at: u32,
    /// Name of an errno, or short, slow, kill, kill-after, power, power-after or jump.
    pub action: String,
    /// Number of bytes, milliseconds or seconds, or a seed, depending on the action; 0 if the action has none, and for the worst power cut.
    pub number: i64,
}

impl Fault {
    /// Returns true if the process dies by the fault.
    pub fn is_death(&self) -> bool {
        self.action.starts_with("kill") || self.action.starts_with("power")
    }

    /// Returns true if the fault loses bytes that were not synced.
    pub fn is_power_cut(&self) -> bool {
        self.action.starts_with("power")
    }

    /// Returns true for events of normal operation: a signal interrupts a call, or a call does part of its work or takes long.
    pub fn is_ordinary(&self) -> bool {
        ["EINTR", "short", "slow"].contains(&self.action.as_str())
    }

    /// Returns true if a call is refused and the program cannot simply retry it.
    pub fn is_refusal(&self) -> bool {
        self.action.starts_with('E') && self.action != "EINTR"
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {} {}", self.kind, self.name, self.at, self.action)?;
        if self.number == 0 { Ok(()) } else { write!(f, " {}", self.number) }
    }
}

impl FromStr for Fault {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let [kind, name, at, action, number @ ..] = &words[..] else { return Err(format!("{text:?} is no fault")) };
        let whole = |word: &str| word.parse().map_err(|_| format!("{text:?}: {word:?} is no number"));
        Ok(Self {
            kind: (*kind).into(),
            name: (*name).into(),
            at: at.parse().map_err(|_| format!("{text:?}: {at:?} is no number"))?,
            action: (*action).into(),
            number: number.first().map_or(Ok(0), |word| whole(word))?,
        })
    }
}

/// Faults of one run of the program, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan(pub Vec<Fault>);

impl Plan {
    /// Returns the faults as text, one per line.
    pub fn lines(&self) -> String {
        self.0.iter().map(|fault| format!("{fault}\n")).collect()
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let faults: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&faults.join("; "))
    }
}

impl FromStr for Plan {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.split(';').filter(|fault| !fault.trim().is_empty()).map(str::parse).collect::<Result<_, _>>().map(Self)
    }
}

#[test]
fn a_plan_survives_writing_and_reading() {
    let text = "write rows.blocks 2 ENOSPC+; sync * 4 power-after 17; clock * 1 jump -3600";
    let plan: Plan = text.parse().unwrap();
    assert_eq!(plan.to_string(), text);
    assert_eq!(plan.0.iter().map(Fault::is_death).collect::<Vec<_>>(), [false, true, false]);
    assert_eq!(plan.0[2].number, -3600);
    for no_plan in ["write rows.blocks", "write a b EIO", "write a 1 short x"] {
        assert!(no_plan.parse::<Plan>().is_err(), "{no_plan}");
    }
}
