//! A person says that a robot which was to be towed has been moved.
//!
//! The body is JSON, `{"to": [x, y]}` with the cell in the site's own coordinates, or `{}`. It has to be
//! declared as JSON for the reason that [`requests`](super::requests) has. The robot's request is decided anew.

use std::sync::Arc;

use axum::{
    Json,
    extract::{Path, State, rejection::JsonRejection},
    http::StatusCode,
    response::Response,
};
use protocol::RobotId;
use serde::Deserialize;

use super::requests::{Trouble, order};
use crate::{core::orders::Order, daemon::Desk, site::Site};

/// What a person says.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Moved {
    #[serde(default)]
    to: Option<[i32; 2]>,
}

pub(super) async fn moved(
    State((desk, site)): State<(Desk, Arc<Site>)>,
    Path(robot): Path<u16>,
    moved: Result<Json<Moved>, JsonRejection>,
) -> Response {
    let to = match moved {
        Ok(Json(moved)) => moved.to,
        Err(error) => return Trouble::answer(error.status(), "unreadable", error.body_text()),
    };
    let to = match to.map(|[x, y]| site.cell_at(x, y)).transpose() {
        Ok(cell) => cell.map(|cell| site.position(cell)),
        Err(outside) => {
            return Trouble::answer(StatusCode::UNPROCESSABLE_ENTITY, "out_of_range", outside.to_string());
        }
    };
    order(&desk, Order::Towed { robot: RobotId(robot), to }, StatusCode::OK).await
}
