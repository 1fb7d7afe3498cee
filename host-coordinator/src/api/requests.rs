//! A person, or a fleet manager, asks for a robot's charge over HTTP.
//!
//! The body has to be declared as JSON, which no foreign web page can do unasked: a browser asks us first
//! whether it may, and is not answered.

use axum::{
    Json,
    extract::{Path, State, rejection::JsonRejection},
    http::StatusCode,
    response::{IntoResponse, Response},
};
use protocol::{RequestId, RobotId, TaskId, TaskPriority};
use serde::{Deserialize, Serialize};

use crate::{
    core::orders::{Order, Refusal},
    daemon::Desk,
};

/// Who is to be charged.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Asked {
    robot: RobotId,
    #[serde(default)]
    task: Option<TaskId>,
    #[serde(default)]
    priority: Option<u8>,
}

/// Why something was not done.
#[derive(Debug, Serialize)]
pub(super) struct Trouble {
    /// One word for programs.
    error: &'static str,
    /// A sentence for people.
    message: String,
}

impl Trouble {
    pub(super) fn answer(status: StatusCode, error: &'static str, message: String) -> Response {
        (status, Json(Self { error, message })).into_response()
    }
}

pub(super) async fn open(State(desk): State<Desk>, asked: Result<Json<Asked>, JsonRejection>) -> Response {
    let Asked { robot, task, priority } = match asked {
        Ok(Json(asked)) => asked,
        Err(error) => return Trouble::answer(error.status(), "unreadable", error.body_text()),
    };
    let Some(priority) = priority.map_or(Some(TaskPriority::USUAL), |value| TaskPriority::new(value).ok())
    else {
        let most = TaskPriority::MAX.get();
        let message = format!("a priority is from 0 to {most}");
        return Trouble::answer(StatusCode::UNPROCESSABLE_ENTITY, "out_of_range", message);
    };
    order(&desk, Order::Charge { robot, task, priority }, StatusCode::CREATED).await
}

pub(super) async fn withdraw(State(desk): State<Desk>, Path(request): Path<u32>) -> Response {
    order(&desk, Order::Withdraw { request: RequestId(request) }, StatusCode::OK).await
}

pub(super) async fn order(desk: &Desk, order: Order, done: StatusCode) -> Response {
    match desk.order(order).await {
        Ok(Ok(ordered)) => (done, Json(ordered)).into_response(),
        Ok(Err(refusal)) => {
            let (status, error) = match refusal {
                Refusal::UnknownRobot(_) => (StatusCode::NOT_FOUND, "unknown_robot"),
                Refusal::NotToBeTowed(_) => (StatusCode::NOT_FOUND, "not_to_be_towed"),
                Refusal::UnknownRequest(_) => (StatusCode::NOT_FOUND, "unknown_request"),
                Refusal::Unheard(_) => (StatusCode::CONFLICT, "unheard"),
                Refusal::Waiting { .. } => (StatusCode::CONFLICT, "waiting"),
                Refusal::Charging(_) => (StatusCode::CONFLICT, "charging"),
                Refusal::NotOrdered(_) => (StatusCode::CONFLICT, "not_ordered"),
            };
            Trouble::answer(status, error, refusal.to_string())
        }
        Err(busy) => Trouble::answer(StatusCode::SERVICE_UNAVAILABLE, "busy", busy.to_string()),
    }
}
