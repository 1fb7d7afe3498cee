//! What the API tells, by HTTP and by WebSocket.

use std::time::Duration;

use protocol::{Activity, Deframer, DeviceId, EnergyJ, Message, Recipient, RobotId, RobotState};
use serde_json::Value;
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::TcpStream,
    time::timeout,
};

use crate::{
    loopback::{start, until},
    udp_world::{World, hello, sessions},
};

async fn get(daemon: std::net::SocketAddr, path: &str) -> (String, String) {
    let mut stream = TcpStream::connect(daemon).await.unwrap();
    let request = format!("GET {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (head.lines().next().unwrap().to_owned(), body.to_owned())
}

/// Every key of the state as the API promises it, for a dashboard written by others.
#[tokio::test(flavor = "multi_thread")]
async fn the_state_has_the_promised_form() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, clock) = start(folder.path()).await;
    let world = World::start(daemon.addresses().udp, clock, &[2], &[3]);
    until(&daemon, "decided", |view| !view.decisions.is_empty() && view.robots[0].pile.is_some()).await;
    let (status, body) = get(http(&daemon), "/api/v1/state").await;
    assert_eq!(status, "HTTP/1.1 200 OK");
    let state: Value = serde_json::from_str(&body).unwrap();
    let keys = |value: &Value| -> Vec<String> {
        let mut keys: Vec<_> = value.as_object().unwrap().keys().cloned().collect();
        keys.sort();
        keys
    };
    assert_eq!(
        keys(&state),
        [
            "charges",
            "decisions",
            "degraded",
            "epoch",
            "helps",
            "insecure",
            "now_ms",
            "piles",
            "robots",
            "site",
            "totals",
            "warnings"
        ]
    );
    let site = &state["site"];
    assert_eq!(
        keys(site),
        ["doors", "frame", "height", "name", "resolution_m", "subareas", "walls", "width"]
    );
    assert_eq!(keys(&site["doors"][0]), ["at", "congestion", "id", "joins", "open"]);
    assert_eq!(keys(&site["subareas"][0]), ["at", "name"]);
    assert_eq!(keys(&site["frame"]), ["origin", "y_up"]);
    let blocked: u64 = site["walls"].as_array().unwrap().iter().map(|run| run[2].as_u64().unwrap()).sum();
    assert!(blocked > 1_000 && blocked < 5_000, "{blocked} of 10000 cells are walls");
    // Pile 2 of Table 1 is at (44, 100), y up from 1.
    let pile = &state["piles"][1];
    assert_eq!(pile["id"], 2);
    assert_eq!(
        keys(pile),
        [
            "at",
            "availability",
            "contradiction",
            "elapsed_s",
            "energised",
            "faults",
            "holder",
            "id",
            "lease",
            "next",
            "planned_s",
            "remaining"
        ]
    );
    assert_eq!(keys(&pile["lease"]), ["epoch", "expiry_ms", "id", "local", "phase", "robot"]);
    assert_eq!(keys(&state["robots"][0]), ["activity", "at", "battery", "energy_j", "id", "pile", "route"]);
    let decision = &state["decisions"][0];
    assert_eq!(
        keys(decision),
        [
            "asked_at_ms",
            "at_ms",
            "beside",
            "chosen",
            "energy_j",
            "explanations",
            "id",
            "is_critical",
            "policy",
            "position",
            "reach",
            "request",
            "robot",
            "stage",
            "standing_w",
            "sure_reach",
            "urgency",
            "waited_s"
        ]
    );
    let chosen = &decision["explanations"].as_array().unwrap().iter().find(|row| row["verdict"] == "chosen");
    assert_eq!(
        keys(chosen.unwrap()),
        [
            "availability",
            "distance",
            "free_in_s",
            "next_is_open",
            "pile",
            "probability",
            "reason",
            "remaining",
            "score",
            "stage",
            "stands_here",
            "times",
            "verdict"
        ]
    );
    assert_eq!(
        keys(&chosen.unwrap()["times"]),
        ["back_s", "charge_s", "doors_s", "drive_s", "free_in_s", "lasts_s"]
    );
    assert_eq!(
        keys(&state["totals"]),
        [
            "charges_completed",
            "energy_j",
            "granted_w",
            "mean_wait_s",
            "power_cap_w",
            "preempted",
            "requests",
            "stranded",
            "waiting",
            "worst_wait_s"
        ]
    );
    let (status, page) = get(http(&daemon), "/").await;
    assert!(status.ends_with("200 OK") && page.contains("<html"), "{status}");
    assert!(get(http(&daemon), "/nothing").await.0.contains("404"));
    world.stop();
    daemon.shutdown().await;
}

/// `chargehand explain` with these arguments: whether it succeeded, and what it printed.
async fn explain(arguments: Vec<String>) -> (bool, String) {
    let explained = tokio::task::spawn_blocking(move || {
        std::process::Command::new(env!("CARGO_BIN_EXE_chargehand")).arg("explain").args(arguments).output()
    });
    let output = explained.await.unwrap().unwrap();
    let text = if output.status.success() { output.stdout } else { output.stderr };
    (output.status.success(), String::from_utf8(text).unwrap())
}

#[tokio::test(flavor = "multi_thread")]
async fn a_decision_is_explained_by_the_running_coordinator_after_a_restart_and_from_its_log() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, clock) = start(folder.path()).await;
    let world = World::start(daemon.addresses().udp, clock, &[2], &[3]);
    until(&daemon, "decided", |view| view.decisions.iter().any(|decision| decision.chosen.is_some())).await;
    let decision = daemon.view().borrow().decisions[0].clone();
    world.stop();
    daemon.shutdown().await;

    let id = decision.id.to_string();
    let log = folder.path().join("events.sqlite").display().to_string();
    let (ok, read) = explain(vec![id.clone(), "--log".into(), log.clone(), "--json".into()]).await;
    assert!(ok, "{read}");
    assert_eq!(serde_json::from_str::<host_coordinator::core::Decision>(&read).unwrap(), decision);
    let (ok, error) = explain(vec!["77".into(), "--log".into(), log.clone()]).await;
    assert!(!ok && error.contains("no decision 77; its newest is"), "{error}");
    let missing = format!("{log}.none");
    let (ok, error) = explain(vec!["0".into(), "--log".into(), missing.clone()]).await;
    assert!(!ok && error.contains(&missing) && !std::path::Path::new(&missing).exists(), "{error}");

    let (daemon, _) = start(folder.path()).await;
    let (status, body) = get(http(&daemon), &format!("/api/v1/decisions/{id}")).await;
    assert_eq!(status, "HTTP/1.1 200 OK");
    assert_eq!(serde_json::from_str::<host_coordinator::core::Decision>(&body).unwrap(), decision);
    let (status, body) = get(http(&daemon), "/api/v1/decisions/77").await;
    assert!(status.contains("404") && body.contains("no decision 77"), "{status} {body}");
    let url = format!("http://{}", http(&daemon));
    let (ok, told) = explain(vec![id, "--url".into(), url.clone()]).await;
    assert!(ok && told.contains("robot 3 goes to pile 2") && told.contains("silent for too long"), "{told}");
    println!("{told}");
    let (ok, error) = explain(vec!["77".into(), "--url".into(), url.clone()]).await;
    assert!(!ok && error.contains("no decision 77"), "{error}");
    daemon.shutdown().await;
    let (ok, error) = explain(vec!["0".into(), "--url".into(), url]).await;
    assert!(!ok && error.contains("does not answer"), "{error}");
}

/// What is answered to a request with a body: the status and the JSON.
async fn send(daemon: std::net::SocketAddr, method: &str, path: &str, body: &str) -> (u16, Value) {
    let mut stream = TcpStream::connect(daemon).await.unwrap();
    let request = format!(
        "{method} {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Type: application/json\r\n\
         Content-Length: {}\r\n\r\n{body}",
        body.len()
    );
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    let status = head.split(' ').nth(1).unwrap().parse().unwrap();
    (status, serde_json::from_str(body).unwrap_or_else(|_| panic!("{answer}")))
}

#[tokio::test(flavor = "multi_thread")]
async fn a_person_asks_for_a_robot_and_takes_that_back() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, _) = start(folder.path()).await;
    let refused = async |body: &str, status: u16, error: &str| {
        let (code, answer) = send(http(&daemon), "POST", "/api/v1/requests", body).await;
        assert_eq!((code, &answer["error"]), (status, &error.into()), "{body}: {answer}");
        assert!(answer["message"].as_str().is_some_and(|text| !text.is_empty()), "{answer}");
    };
    refused(r#"{"robot": 77}"#, 404, "unknown_robot").await;
    refused(r#"{"robot": 3}"#, 409, "unheard").await;
    refused(r#"{"robot": 3, "priority": 11}"#, 422, "out_of_range").await;
    refused(r#"{"robot": 3, "pile": 2}"#, 422, "unreadable").await;
    refused("{", 400, "unreadable").await;

    // A robot at work that has enough.
    let mut robot = sessions(DeviceId::Robot(RobotId(3)));
    let link = tokio::net::UdpSocket::bind("127.0.0.1:0").await.unwrap();
    link.connect(daemon.addresses().udp).await.unwrap();
    let mut buffer = [0; 512];
    let coordinator = Recipient::Device(DeviceId::Coordinator);
    link.send(&robot.seal(coordinator, &hello()).unwrap()).await.unwrap();
    let length = timeout(Duration::from_secs(10), link.recv(&mut buffer)).await.unwrap().unwrap();
    Deframer::new().feed(&buffer[..length], |packet| drop(robot.open(packet.unwrap()).unwrap()));
    let site = host_coordinator::site::Site::fig7().unwrap();
    let works = RobotState {
        position: site.position(site.piles[0].cell),
        energy: EnergyJ::new(9_000.0).unwrap(),
        activity: Activity::Working,
        accepted: None,
    };
    link.send(&robot.seal(coordinator, &Message::RobotState(works)).unwrap()).await.unwrap();
    until(&daemon, "heard", |view| view.robots[0].activity == "working").await;
    let body = r#"{"robot": 3, "task": 2, "priority": 8}"#;
    let (status, ordered) = send(http(&daemon), "POST", "/api/v1/requests", body).await;
    assert_eq!((status, &ordered["robot"]), (201, &3.into()), "{ordered}");
    refused(body, 409, "waiting").await;
    let decision = ordered["decision"].as_u64().unwrap();
    let (_, told) = get(http(&daemon), &format!("/api/v1/decisions/{decision}")).await;
    let told: Value = serde_json::from_str(&told).unwrap();
    assert_eq!((&told["request"], &told["robot"]), (&ordered["request"], &ordered["robot"]));

    let path = format!("/api/v1/requests/{}", ordered["request"]);
    let (status, withdrawn) = send(http(&daemon), "DELETE", &path, "").await;
    assert_eq!((status, &withdrawn["request"]), (200, &ordered["request"]));
    let (status, gone) = send(http(&daemon), "DELETE", &path, "").await;
    assert_eq!((status, &gone["error"]), (404, &"unknown_request".into()));
    daemon.shutdown().await;

    // It is in the log, with who asked.
    let log = host_coordinator::store::Store::read_only(&folder.path().join("events.sqlite")).unwrap();
    use host_coordinator::core::{Fact, event::Opener};
    assert!(log.iter().any(|event| matches!(event.fact, Fact::Asked { opener: Opener::Person, .. })));
    assert!(log.iter().any(|event| matches!(event.fact, Fact::Withdrawn { .. })));
}

/// Just enough of RFC 6455 to read a server's text messages.
struct WebSocket(TcpStream);

impl WebSocket {
    async fn open(daemon: std::net::SocketAddr) -> Self {
        let mut stream = TcpStream::connect(daemon).await.unwrap();
        let request = "GET /api/v1/changes HTTP/1.1\r\nHost: x\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
                       Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n";
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            head.push(stream.read_u8().await.unwrap());
        }
        assert!(head.starts_with(b"HTTP/1.1 101"), "{}", String::from_utf8_lossy(&head));
        Self(stream)
    }

    async fn next(&mut self) -> Value {
        assert_eq!(self.0.read_u8().await.unwrap(), 0x81, "a whole text message");
        let length = match self.0.read_u8().await.unwrap() {
            126 => self.0.read_u16().await.unwrap().into(),
            127 => self.0.read_u64().await.unwrap(),
            short => short.into(),
        };
        let mut text = vec![0; length as usize];
        self.0.read_exact(&mut text).await.unwrap();
        serde_json::from_slice(&text).unwrap()
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_reader_of_changes_knows_the_state_without_asking_again() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, clock) = start(folder.path()).await;
    let mut socket = WebSocket::open(http(&daemon)).await;
    let mut state = socket.next().await;
    assert_eq!((&state["type"], state["piles"].as_array().unwrap().len()), (&"state".into(), 13));
    let world = World::start(daemon.addresses().udp, clock, &[2], &[3]);
    let follow = async {
        let mut changes = 0;
        while state["totals"]["charges_completed"].as_u64() == Some(0) {
            let change = socket.next().await;
            assert_eq!(change["type"], "change");
            for table in ["piles", "robots"] {
                for row in change[table].as_array().unwrap() {
                    let rows = state[table].as_array_mut().unwrap();
                    *rows.iter_mut().find(|old| old["id"] == row["id"]).unwrap() = row.clone();
                }
            }
            let silent = change["piles"].as_array().unwrap().iter().all(|row| row["id"] == 2);
            assert!(changes < 2 || silent, "only rows that changed are told");
            for decision in change["decisions"].as_array().unwrap().iter().rev() {
                state["decisions"].as_array_mut().unwrap().insert(0, decision.clone());
            }
            state["totals"] = change["totals"].clone();
            changes += 1;
        }
    };
    timeout(Duration::from_secs(20), follow).await.unwrap();
    let ids: Vec<_> = state["decisions"]
        .as_array()
        .unwrap()
        .iter()
        .map(|decision| decision["id"].as_u64().unwrap())
        .collect();
    assert!(!ids.is_empty() && ids.iter().rev().copied().eq(0..ids.len() as u64), "{ids:?}");
    world.stop();
    daemon.shutdown().await;
}

fn http(daemon: &host_coordinator::daemon::Daemon) -> std::net::SocketAddr {
    daemon.addresses().http.unwrap()
}

async fn post(daemon: std::net::SocketAddr, path: &str, kind: &str, body: &str) -> String {
    let mut stream = TcpStream::connect(daemon).await.unwrap();
    let length = body.len();
    let head = format!("Host: x\r\nConnection: close\r\nContent-Type: {kind}\r\nContent-Length: {length}");
    stream.write_all(format!("POST {path} HTTP/1.1\r\n{head}\r\n\r\n{body}").as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    answer
}

/// A robot strands and there is no mobile charger: a person tows it, says so, and it is in the log.
#[tokio::test(flavor = "multi_thread")]
async fn a_person_says_that_a_robot_was_towed() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, clock) = start(folder.path()).await;
    let http = http(&daemon);
    let json = "application/json";
    let answer = post(http, "/api/v1/tows/3", json, "{}").await;
    assert!(answer.starts_with("HTTP/1.1 404") && answer.contains("robot 3 is not to be towed"), "{answer}");
    let world = World::start(daemon.addresses().udp, clock, &[], &[3]);
    world.strand();
    until(&daemon, "a tow is wanted", |view| view.helps.iter().any(|help| help.stage == "tow")).await;
    for (kind, body, status) in [
        ("text/plain", "{}", "415"),
        (json, r#"{"too": [1, 1]}"#, "422"),
        (json, r#"{"to": [1, 4000]}"#, "422"),
        (json, r#"{"to": [40, 64]}"#, "200"),
        (json, r#"{"to": [40, 64]}"#, "404"),
    ] {
        let answer = post(http, "/api/v1/tows/3", kind, body).await;
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{body}: {answer}");
    }
    daemon.shutdown().await;
}
