//! Piles that the robot passes are counted once an approach and reported until acknowledged.

use firmware_chassis::Input;
use firmware_common::reader::TagRead;
use protocol::*;

use crate::bench::Bench;

const PILE: TagId = TagId([9; 12]);

fn reports(bench: &Bench) -> Vec<PassReport> {
    let reports = bench.sent.iter().filter_map(|message| match message {
        Message::PassReport(report) => Some(report.clone()),
        _ => None,
    });
    reports.collect()
}

/// Drives by a pile: its tag is read ten times in a second.
fn pass(bench: &mut Bench) {
    for _ in 0..10 {
        bench.wait(0.1);
        bench.step(Input::Tag(TagRead { tag: PILE, rssi_dbm: -50 }));
    }
    bench.wait(4.0);
}

#[test]
fn a_pass_is_counted_once_in_its_period_and_reported_until_acknowledged() {
    let mut bench = Bench::new();
    pass(&mut bench);
    assert_eq!(reports(&bench), [], "the site's time is not known");

    // Asked again every two seconds; three o'clock is in the second of the periods of two hours.
    let asked_at = loop {
        let outputs = bench.tick();
        if let Some(Message::TimeRequest(request)) =
            outputs.messages.iter().find(|message| matches!(message, Message::TimeRequest(_)))
        {
            break request.asked_at;
        }
    };
    bench.hear(Message::TimeSync(TimeSync { asked_at, site_now: SiteMillis(3 * 3_600_000) }));
    bench.wait(5.0);
    let sent = reports(&bench);
    let mut passes = heapless::Vec::new();
    passes.push(PassCount { tag: PILE, period: 1, passes: 1 }).unwrap();
    assert!(sent.len() >= 2, "it is repeated");
    assert!(sent.iter().all(|report| *report
        == PassReport { report: ReportId { boot: BootEpoch(0), number: 1 }, passes: passes.clone() }));

    bench.hear(Message::Ack(Ack { of: Reference::Report(ReportId { boot: BootEpoch(0), number: 1 }) }));
    bench.sent.clear();
    bench.wait(5.0);
    assert_eq!(reports(&bench), []);
    pass(&mut bench);
    assert_eq!(reports(&bench)[0], PassReport { report: ReportId { boot: BootEpoch(0), number: 2 }, passes });
}
