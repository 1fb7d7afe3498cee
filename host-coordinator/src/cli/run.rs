//! `chargehand run`: the coordinator of a real site.

use std::{
    io::{self, IsTerminal as _},
    path::PathBuf,
    sync::Arc,
};

use host_coordinator::{
    config::Config,
    daemon::{Daemon, SiteClock},
};
use tokio::runtime::Runtime;

use super::{Outcome, out, stop::stop_signal};

/// Run the coordinator of a site until Ctrl-C or SIGTERM
#[derive(clap::Args)]
pub struct Run {
    /// Its configuration; `chargehand check` says what is wrong with one
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

impl Run {
    pub fn run(self) -> Outcome {
        let (config, site) = Config::load(&self.config)?;
        tracing_subscriber::fmt()
            .with_writer(io::stderr)
            .with_ansi(io::stderr().is_terminal())
            .with_max_level(tracing::Level::INFO)
            .with_target(false)
            .init();
        Runtime::new()?.block_on(async {
            let stop = stop_signal()?;
            let daemon = Daemon::start(Arc::new(site), &config, SiteClock::real()).await?;
            if let Some(dashboard) = daemon.addresses().http {
                out(&format!("dashboard: http://{dashboard}"))?;
            }
            stop.await;
            tracing::info!("stopping");
            daemon.shutdown().await;
            Ok(())
        })
    }
}
