//! Questions about the past, which only the thread with the event log can answer.

use std::time::Duration;

use tokio::{
    sync::{mpsc, oneshot},
    time,
};

use super::engine::Engine;
use crate::{core::Decision, store::StoreError};

/// Questions that wait.
const WAITING: usize = 16;
/// The log answers between two batches of inputs, many times a second; if it does not, it can't be written.
const PATIENCE: Duration = Duration::from_secs(5);

/// Why a question has no answer.
#[derive(Debug, thiserror::Error)]
pub enum Unanswered {
    /// The coordinator does nothing but try to write its log, or is stopping.
    #[error("the coordinator does not answer now; its page says whether its disk is full")]
    Busy,
    /// The log can't be read.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Asks the running coordinator's event log.
#[derive(Clone, Debug)]
pub struct History {
    questions: mpsc::Sender<Question>,
}

/// Which decision is wanted, and by whom.
#[derive(Debug)]
struct Question {
    decision: u64,
    answer: oneshot::Sender<Result<Option<Decision>, StoreError>>,
}

/// The end of the questions that has the log.
#[derive(Debug)]
pub struct Questions {
    waiting: mpsc::Receiver<Question>,
}

impl History {
    /// Both ends.
    pub fn new() -> (Self, Questions) {
        let (sender, waiting) = mpsc::channel(WAITING);
        (Self { questions: sender }, Questions { waiting })
    }

    /// A decision that was ever made, by its number; `None` if there was none with it.
    ///
    /// # Errors
    /// [`Unanswered`] says why nobody knows.
    pub async fn decision(&self, decision: u64) -> Result<Option<Decision>, Unanswered> {
        let (answer, answered) = oneshot::channel();
        let asked = async {
            self.questions.send(Question { decision, answer }).await.map_err(|_| Unanswered::Busy)?;
            Ok(answered.await.map_err(|_| Unanswered::Busy)??)
        };
        time::timeout(PATIENCE, asked).await.unwrap_or(Err(Unanswered::Busy))
    }
}

impl Questions {
    /// Answers what waits.
    pub fn answer(&mut self, engine: &Engine) {
        while let Ok(question) = self.waiting.try_recv() {
            // Whoever asked may be gone.
            let _ = question.answer.send(engine.decision(question.decision));
        }
    }
}
