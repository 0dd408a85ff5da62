// Millimetres, to 1.1 million kilometres.
fn depth_code(nanometres: u64) -> u64 {
    return nanometres / 1000000lu;
}
