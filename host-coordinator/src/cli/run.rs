//! `chargehand run`: the coordinator of a real site.

use std::{path::PathBuf, sync::Arc};

use host_coordinator::{
    config::Config,
    daemon::{Daemon, SiteClock},
    site::Site,
};
use tokio::runtime::Runtime;

use super::{Outcome, out};

/// Run the coordinator of a site until Ctrl-C or SIGTERM
#[derive(clap::Args)]
pub struct Run {
    /// Its configuration; `chargehand check` says what is wrong with one
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

impl Run {
    pub fn run(self) -> Outcome {
        let config = Config::load(&self.config)?;
        let site = Arc::new(Site::load(&config.site)?);
        tracing_subscriber::fmt()
            .with_writer(std::io::stderr)
            .with_max_level(tracing::Level::INFO)
            .with_target(false)
            .init();
        Runtime::new()?.block_on(async {
            let stop = stop_signal()?;
            let daemon = Daemon::start(site, &config, SiteClock::real()).await?;
            out(&format!("dashboard: http://{}", daemon.addresses().http))?;
            stop.await;
            tracing::info!("stopping");
            daemon.shutdown().await;
            Ok(())
        })
    }
}

/// Ends when the operator or the system wants the program to end.
#[cfg(unix)]
fn stop_signal() -> std::io::Result<impl Future<Output = ()>> {
    use tokio::signal::unix::{SignalKind, signal};
    let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
    Ok(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
    })
}

/// Ends when the operator wants the program to end.
#[cfg(not(unix))]
fn stop_signal() -> std::io::Result<impl Future<Output = ()>> {
    Ok(async {
        // Without a way to be told, it runs until it is killed.
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    })
}
