//! Plans of faults: which call fails, and how. In: text, as `write rows.blocks 2 ENOSPC; rename manifest.json 1 kill`. Out: a plan, and its text again,
//! which `preload.c` reads.

use std::{fmt, str::FromStr};

/// One fault: the `at`-th call of a kind on files whose names end in `name`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Kind of call, as `preload.c` names it.
    pub kind: String,
    /// End of the file's name; `*` for any.
    pub name: String,
    /// From 1.
    pub at: u32,
    /// An errno's name, or short, slow, kill, kill-after, power, power-after, jump.
    pub action: String,
    /// Bytes, milliseconds, a seed or seconds, by the action; 0 where it has none, and for the worst power cut.
    pub number: i64,
}

impl Fault {
    /// The process dies by it.
    pub fn is_death(&self) -> bool {
        self.action.starts_with("kill") || self.action.starts_with("power")
    }

    /// Bytes that were not synced are lost by it.
    pub fn is_power_cut(&self) -> bool {
        self.action.starts_with("power")
    }

    /// A system does this every day: a signal interrupts a call, or a call does a part of its work, or takes long.
    pub fn is_ordinary(&self) -> bool {
        ["EINTR", "short", "slow"].contains(&self.action.as_str())
    }

    /// A call is refused, and the program cannot simply try again.
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

/// Faults of one run of the program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan(pub Vec<Fault>);

impl Plan {
    /// One fault a line.
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
fn a_plan_is_read_as_it_is_written() {
    let text = "write rows.blocks 2 ENOSPC+; sync * 4 power-after 17; clock * 1 jump -3600";
    let plan: Plan = text.parse().unwrap();
    assert_eq!(plan.to_string(), text);
    assert_eq!(plan.0.iter().map(Fault::is_death).collect::<Vec<_>>(), [false, true, false]);
    assert_eq!(plan.0[2].number, -3600);
    for no_plan in ["write rows.blocks", "write a b EIO", "write a 1 short x"] {
        assert!(no_plan.parse::<Plan>().is_err(), "{no_plan}");
    }
}
