//! How piles are chosen for all robots that wait: policies that can be compared.

use std::{fmt, str::FromStr};

use super::{
    explain::Choice,
    joint::Joint,
    multistage::{Multistage, Rule},
    nearest::{Nearest, Order},
    situation::Situation,
};

/// Chooses for all robots that wait at one instant.
pub trait ChargingPolicy: fmt::Debug + Send + Sync {
    /// A choice for each of the situation's askers, in their order. No pile is chosen twice.
    fn choose(&self, situation: &Situation) -> Vec<Choice>;
}

/// The policies there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum PolicyName {
    /// All robots together, by the time that their charges keep them from work: [`Joint`].
    #[default]
    Joint,
    /// One robot after the other as it asked, by LMPP's eq. 9, corrected: [`Multistage`].
    Lmpp,
    /// The same as the paper prints it.
    LmppLiteral,
    /// The most urgent robot first, each to the nearest free pile, with preemption (Access 2.3): [`Nearest`].
    Access,
    /// One robot after the other as it asked, each to the nearest free pile: what fleet managers do today.
    Nearest,
}

impl PolicyName {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Joint, Self::Lmpp, Self::LmppLiteral, Self::Access, Self::Nearest];

    /// The policy, where a charge this far done counts as almost done (`q_threshold`, 0 to 1).
    #[must_use]
    pub fn policy(self, q_threshold: f64) -> Box<dyn ChargingPolicy> {
        match self {
            Self::Joint => Box::new(Joint),
            Self::Lmpp => Box::new(Multistage { rule: Rule::Corrected, q_threshold }),
            Self::LmppLiteral => Box::new(Multistage { rule: Rule::PaperLiteral, q_threshold }),
            Self::Access => Box::new(Nearest { order: Order::Urgency }),
            Self::Nearest => Box::new(Nearest { order: Order::Asked }),
        }
    }

    /// What it is called in configurations, on the command line and in decisions.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Joint => "joint",
            Self::Lmpp => "lmpp",
            Self::LmppLiteral => "lmpp-literal",
            Self::Access => "access",
            Self::Nearest => "nearest",
        }
    }
}

impl fmt::Display for PolicyName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// There is no such policy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no policy {0:?}: choose joint, lmpp, lmpp-literal, access or nearest")]
pub struct NoPolicy(String);

impl FromStr for PolicyName {
    type Err = NoPolicy;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::ALL.into_iter().find(|policy| policy.name() == text).ok_or_else(|| NoPolicy(text.to_owned()))
    }
}

#[cfg(test)]
#[path = "policy_tests.rs"]
mod tests;
