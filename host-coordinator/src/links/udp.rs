//! UDP: a datagram carries whole frames, usually one.

use protocol::Deframer;

use super::{Inbound, Peer};

/// Reads datagrams for ever.
pub async fn receive(inbound: Inbound) {
    let mut buffer = [0; 2048];
    loop {
        let (length, address) = match inbound.links.udp.recv_from(&mut buffer).await {
            Ok(received) => received,
            // On some systems an earlier datagram to a closed port is reported here.
            Err(error) => {
                inbound.links.warnings.note(format!("cannot receive by UDP: {error}"));
                tokio::task::yield_now().await;
                continue;
            }
        };
        let peer = Peer::Udp(address);
        let datagram = buffer.get(..length).unwrap_or_default();
        // What a busy coordinator gives back is lost, as datagrams may be.
        Deframer::new().feed(datagram, |found| drop(inbound.take(&peer, address, found)));
    }
}
