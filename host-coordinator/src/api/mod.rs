//! What programs and the dashboard can ask: the state as JSON, and its changes by WebSocket.
//!
//! | path | answer |
//! |---|---|
//! | `GET /api/v1/state` | a [`View`] |
//! | `GET /api/v1/decisions/{id}` | a [`Decision`] that was ever made, with its explanation; 404 if there is none |
//! | `POST /api/v1/requests` | asks for a robot's charge: 201, or why not |
//! | `DELETE /api/v1/requests/{request}` | takes such a request back |
//! | `GET /api/v1/changes` | WebSocket: a whole view first, then what [`changes`] in it |
//! | `POST /api/v1/tows/{robot}` | a person says that a robot which was to be towed has been moved: 200, or why not |
//! | `GET /` | the dashboard ([`ui`]) |
//!
//! Whoever can reach the API can ask for charges and take their own requests back, in the same queue as robots
//! do (`requests`); no robot or pile can be commanded from here.

pub mod changes;
mod requests;
mod tows;

use std::{sync::Arc, time::Duration};

use axum::{
    Json, Router,
    extract::{
        Path, State,
        ws::{Message, WebSocket, WebSocketUpgrade},
    },
    http::StatusCode,
    response::{IntoResponse, Response},
    routing::{delete, get, post},
};
use serde::Serialize;
use tokio::{net::TcpListener, sync::watch, time};

use self::changes::Change;
use crate::{
    core::{Decision, View},
    daemon::Desk,
    site::Site,
    ui,
};

/// A reader of changes that takes nothing for this long is hung up.
const STUCK: Duration = Duration::from_secs(10);

type Views = watch::Receiver<Arc<View>>;

/// Serves until the task is dropped.
pub async fn serve(listener: TcpListener, views: Views, desk: Desk, site: Arc<Site>) {
    let telling =
        Router::new().route("/api/v1/tows/{robot}", post(tows::moved)).with_state((desk.clone(), site));
    let asking = Router::new()
        .route("/api/v1/decisions/{id}", get(decision))
        .route("/api/v1/requests", post(requests::open))
        .route("/api/v1/requests/{request}", delete(requests::withdraw))
        .with_state(desk);
    let router = Router::new()
        .route("/api/v1/state", get(state))
        .route("/api/v1/changes", get(follow))
        .with_state(views)
        .merge(asking)
        .merge(telling)
        .merge(ui::routes());
    if let Err(error) = axum::serve(listener, router).await {
        tracing::error!("the dashboard has ended: {error}");
    }
}

async fn state(State(views): State<Views>) -> Response {
    let view = Arc::clone(&views.borrow());
    Json(view.as_ref()).into_response()
}

async fn decision(State(desk): State<Desk>, Path(id): Path<u64>) -> Response {
    match desk.decision(id).await {
        Ok(Some(decision)) => Json::<Decision>(decision).into_response(),
        Ok(None) => {
            let text = format!("there is no decision {id}; /api/v1/state has the newest ones");
            (StatusCode::NOT_FOUND, text).into_response()
        }
        Err(error) => (StatusCode::SERVICE_UNAVAILABLE, error.to_string()).into_response(),
    }
}

async fn follow(State(views): State<Views>, upgrade: WebSocketUpgrade) -> Response {
    upgrade.on_upgrade(|socket| tell_changes(socket, views))
}

/// What a WebSocket carries.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Told<'a> {
    State(&'a View),
    Change(Change<'a>),
}

/// Tells a reader the whole view, then each change. Views come at most ten times a second; a
/// slow reader skips some.
async fn tell_changes(mut socket: WebSocket, mut views: Views) {
    let mut known = Arc::clone(&views.borrow_and_update());
    let mut sent = send(&mut socket, &Told::State(&known)).await;
    while sent.is_some() {
        tokio::select! {
            changed = views.changed() => {
                if changed.is_err() {
                    return;
                }
                let view = Arc::clone(&views.borrow_and_update());
                sent = send(&mut socket, &Told::Change(Change::between(&known, &view))).await;
                known = view;
            }
            // Pings are answered while we read; nothing else is expected.
            received = socket.recv() => match received {
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => {}
            }
        }
    }
}

async fn send(socket: &mut WebSocket, told: &Told<'_>) -> Option<()> {
    let text = serde_json::to_string(told).ok()?;
    time::timeout(STUCK, socket.send(Message::text(text))).await.ok()?.ok()
}
