//! `POST /api/v1/tows/{robot}`: a person says that a robot which was to be towed has been moved.
//!
//! The body is JSON, `{"to": [x, y]}` with the cell in the site's own coordinates, or `{}`. It has to be
//! named as JSON, so that no page of another site can send it from a person's browser. The answer comes when
//! it is in the event log; the robot's request is decided anew then.

use std::{sync::Arc, time::Duration};

use axum::{
    Json, Router,
    extract::{Path, State},
    http::StatusCode,
    response::{IntoResponse, Response},
    routing::post,
};
use protocol::RobotId;
use serde::Deserialize;
use tokio::{
    sync::{mpsc, watch},
    time,
};

use crate::{
    core::{Input, View},
    site::Site,
};

/// Recording takes milliseconds; if it does not, the log can't be written.
const PATIENCE: Duration = Duration::from_secs(5);

/// What the route needs.
#[derive(Clone, Debug)]
pub struct Tows {
    /// Where the coordinator listens.
    pub inputs: mpsc::Sender<Input>,
    /// What it knows.
    pub views: watch::Receiver<Arc<View>>,
    /// How its people count cells.
    pub site: Arc<Site>,
}

/// What a person says.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Moved {
    #[serde(default)]
    to: Option<[i32; 2]>,
}

impl Tows {
    pub(super) fn routes(self) -> Router {
        Router::new().route("/api/v1/tows/{robot}", post(moved)).with_state(self)
    }
}

async fn moved(State(mut tows): State<Tows>, Path(robot): Path<u16>, Json(moved): Json<Moved>) -> Response {
    let robot = RobotId(robot);
    let is_wanted = |view: &View| view.helps.iter().any(|help| help.robot == robot && help.stage == "tow");
    if !is_wanted(&tows.views.borrow()) {
        let text = format!("robot {robot} is not to be towed; `helps` in /api/v1/state has those that are");
        return (StatusCode::NOT_FOUND, text).into_response();
    }
    let to = match moved.to.map(|[x, y]| tows.site.cell_at(x, y)).transpose() {
        Ok(cell) => cell.map(|cell| tows.site.position(cell)),
        Err(outside) => return (StatusCode::UNPROCESSABLE_ENTITY, outside.to_string()).into_response(),
    };
    let recorded = async {
        tows.inputs.send(Input::Towed { robot, to }).await.ok()?;
        tows.views.wait_for(|view| !is_wanted(view)).await.ok().map(drop)
    };
    match time::timeout(PATIENCE, recorded).await {
        Ok(Some(())) => StatusCode::NO_CONTENT.into_response(),
        Ok(None) | Err(_) => {
            let text = "the coordinator does not answer now; its page says whether its disk is full";
            (StatusCode::SERVICE_UNAVAILABLE, text).into_response()
        }
    }
}
