// Nanometres to 10 m, micrometres to 10 km, millimetres beyond; each range begins where the last ends.
fn depth_code(nanometres: u64) -> u64 {
    if nanometres < 10000000000lu {
        return nanometres;
    }
    if nanometres < 10000000000000lu {
        return 10000000000lu + (nanometres - 10000000000lu) / 1000lu;
    }
    return 19990000000lu + (nanometres - 10000000000000lu) / 1000000lu;
}
