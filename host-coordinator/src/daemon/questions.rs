//! What the API wants of the thread with the core and the event log: answers about the past, and orders.

use std::time::Duration;

use protocol::{DeviceId, Message};
use tokio::{
    sync::{mpsc, oneshot},
    time,
};

use super::{
    clock::SiteClock,
    engine::{Engine, Ordered},
};
use crate::{
    core::{
        Decision,
        orders::{Order, Refusal},
    },
    store::StoreError,
};

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

/// What has become of an order that was taken to the core.
pub type OrderOutcome = Result<Ordered, Refusal>;

/// Asks the running coordinator, and gives it orders.
#[derive(Clone, Debug)]
pub struct Desk {
    questions: mpsc::Sender<Question>,
}

/// What is wanted, and by whom.
#[derive(Debug)]
enum Question {
    Decision(u64, oneshot::Sender<Result<Option<Decision>, StoreError>>),
    Order(Order, oneshot::Sender<OrderOutcome>),
}

/// The end of the questions that has core and log.
#[derive(Debug)]
pub struct Questions {
    waiting: mpsc::Receiver<Question>,
}

impl Desk {
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
        Ok(self.ask(|answer| Question::Decision(decision, answer)).await??)
    }

    /// Gives an order; the answer comes when it is in the log.
    ///
    /// # Errors
    /// [`Unanswered`] if it can't be recorded now. It may be done later nevertheless.
    pub async fn order(&self, order: Order) -> Result<OrderOutcome, Unanswered> {
        self.ask(|answer| Question::Order(order, answer)).await
    }

    async fn ask<T>(&self, question: impl FnOnce(oneshot::Sender<T>) -> Question) -> Result<T, Unanswered> {
        let (answer, answered) = oneshot::channel();
        let asked = async {
            self.questions.send(question(answer)).await.map_err(|_| Unanswered::Busy)?;
            answered.await.map_err(|_| Unanswered::Busy)
        };
        time::timeout(PATIENCE, asked).await.unwrap_or(Err(Unanswered::Busy))
    }
}

impl Questions {
    /// Answers what waits, and does what is ordered.
    ///
    /// # Errors
    /// An order can't be recorded, and so is not answered: no step is to be made until it is.
    pub fn answer(
        &mut self,
        engine: &mut Engine,
        clock: &SiteClock,
        send: &mut dyn FnMut(DeviceId, Message),
    ) -> Result<(), StoreError> {
        while let Ok(question) = self.waiting.try_recv() {
            // Whoever asked may be gone.
            match question {
                Question::Decision(id, answer) => _ = answer.send(engine.decision(id)),
                Question::Order(order, answer) => {
                    let outcome = engine.order(clock.now(), order, send);
                    engine.commit(send)?;
                    let _ = answer.send(outcome);
                }
            }
        }
        Ok(())
    }
}
