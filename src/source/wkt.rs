//! What well-known text (WKT 1 and 2) calls its coordinate systems: names and EPSG codes, nothing else.

/// A coordinate system inside a WKT: its name, and its EPSG code if it has one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WktPart {
    pub name: String,
    pub epsg: Option<u32>,
}

const HORIZONTAL: [&str; 12] = [
    "PROJCS",
    "PROJCRS",
    "PROJECTEDCRS",
    "GEOGCS",
    "GEOGCRS",
    "GEOGRAPHICCRS",
    "GEODCRS",
    "GEODETICCRS",
    "GEOCCS",
    "LOCAL_CS",
    "ENGCRS",
    "ENGINEERINGCRS",
];
const VERTICAL: [&str; 3] = ["VERT_CS", "VERTCRS", "VERTICALCRS"];

/// The outermost horizontal system: a projected one, else a geographic, geocentric or local one.
pub fn horizontal(wkt: &str) -> Option<WktPart> {
    part(wkt, &HORIZONTAL)
}

/// The vertical system of a compound.
pub fn vertical(wkt: &str) -> Option<WktPart> {
    part(wkt, &VERTICAL)
}

/// True if the outermost horizontal system has longitudes and latitudes. (One of WKT 2's geodetic systems may also be
/// earth-centred, and then says a length.)
pub fn is_geographic(wkt: &str) -> bool {
    const GEOGRAPHIC: [&str; 5] = ["GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", "GEODCRS", "GEODETICCRS"];
    let is = |word: &str, names: &[&str]| names.iter().any(|name| name.eq_ignore_ascii_case(word));
    let first = tokens(wkt).find_map(|token| match token {
        Token::Word(word) if is(word, &HORIZONTAL) => Some(word),
        _ => None,
    });
    first.is_some_and(|word| is(word, &GEOGRAPHIC)) && metres_per_unit(wkt).is_none()
}

/// One step through a WKT.
enum Token<'a> {
    Word(&'a str),
    Text(&'a str),
    Open,
    Close,
}

fn tokens(wkt: &str) -> impl Iterator<Item = Token<'_>> {
    let mut rest = wkt;
    std::iter::from_fn(move || {
        rest = rest.trim_start_matches(|c: char| c.is_whitespace() || c == ',');
        let first = rest.chars().next()?;
        match first {
            '"' => {
                let (text, after) = rest[1..].split_once('"').unwrap_or((&rest[1..], ""));
                rest = after;
                Some(Token::Text(text))
            }
            '[' | '(' | ']' | ')' => {
                rest = &rest[1..];
                Some(if matches!(first, '[' | '(') { Token::Open } else { Token::Close })
            }
            _ => {
                let end = rest.find(['[', '(', ']', ')', ',', '"']).unwrap_or(rest.len());
                let (word, after) = rest.split_at(end);
                rest = after;
                Some(Token::Word(word.trim_end()))
            }
        }
    })
}

/// Name and code of the first node with one of these keywords.
fn part(wkt: &str, keywords: &[&str]) -> Option<WktPart> {
    let mut tokens = tokens(wkt);
    tokens.find(|t| matches!(t, Token::Word(w) if keywords.iter().any(|k| k.eq_ignore_ascii_case(w))))?;
    if !matches!(tokens.next(), Some(Token::Open)) {
        return None;
    }
    let mut found = WktPart::default();
    // Within the node: 0 is its own level, 1 that of its children, whose codes are theirs alone.
    let (mut depth, mut word, mut authority, mut epsg) = (0, "", false, false);
    for (i, token) in tokens.enumerate() {
        match token {
            Token::Text(text) if i == 0 => found.name = text.to_owned(),
            Token::Open => {
                depth += 1;
                authority = depth == 1 && ["AUTHORITY", "ID"].iter().any(|k| k.eq_ignore_ascii_case(word));
                epsg = false;
            }
            Token::Close if depth == 0 => break,
            Token::Close => depth -= 1,
            Token::Text(text) | Token::Word(text) if authority && depth == 1 => {
                if epsg {
                    found.epsg = text.parse().ok();
                    authority = false;
                }
                epsg = text.eq_ignore_ascii_case("EPSG");
            }
            Token::Word(text) => word = text,
            Token::Text(_) => {}
        }
    }
    Some(found)
}

/// Length of the unit of the projected (or local) system's coordinates, metres: `UNIT` of WKT 1, which stands in the
/// system itself, or `LENGTHUNIT` of WKT 2, there or in an axis. Those of ellipsoids and of angles stand elsewhere.
pub fn metres_per_unit(wkt: &str) -> Option<f64> {
    const HOLDERS: [&str; 8] =
        ["PROJCS", "PROJCRS", "PROJECTEDCRS", "GEOCCS", "LOCAL_CS", "ENGCRS", "ENGINEERINGCRS", "AXIS"];
    let is = |word: &str, names: &[&str]| names.iter().any(|name| name.eq_ignore_ascii_case(word));
    let mut open: Vec<&str> = Vec::new();
    let mut word = "";
    for token in tokens(wkt) {
        match token {
            Token::Open => open.push(word),
            Token::Close => drop(open.pop()),
            Token::Text(_) => {}
            Token::Word(text) => {
                if let [.., holder, unit] = open[..]
                    && is(unit, &["UNIT", "LENGTHUNIT"])
                    && is(holder, &HOLDERS)
                    && let Ok(metres) = text.parse::<f64>()
                {
                    return Some(metres).filter(|metres| metres.is_finite() && *metres > 0.0);
                }
                word = text;
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(wkt: &str) -> (Option<WktPart>, Option<WktPart>) {
        (horizontal(wkt), vertical(wkt))
    }

    fn some(name: &str, epsg: Option<u32>) -> Option<WktPart> {
        Some(WktPart { name: name.into(), epsg })
    }

    #[test]
    fn codes_are_those_of_the_system_not_of_its_parts() {
        let projected = r#"PROJCS["A / B",GEOGCS["G",DATUM["D",AUTHORITY["EPSG","6258"]],AUTHORITY["EPSG","4258"]],
            PROJECTION["T"],UNIT["metre",1,AUTHORITY["EPSG","9001"]],AUTHORITY["EPSG","25832"]]"#;
        assert_eq!(told(projected), (some("A / B", Some(25832)), None));
        let without = projected.replace(r#",AUTHORITY["EPSG","25832"]"#, "");
        assert_eq!(told(&without), (some("A / B", None), None));
        let compound = format!(
            r#"COMPD_CS["both",{projected},VERT_CS["H",VERT_DATUM["d",2005,AUTHORITY["EPSG","5129"]],AUTHORITY["EPSG","5941"]],AUTHORITY["EPSG","7416"]]"#
        );
        assert_eq!(told(&compound), (some("A / B", Some(25832)), some("H", Some(5941))));
        let second = r#"PROJCRS["W (x)", BASEGEOGCRS["B",ID["EPSG",4326]], ID["EPSG",32723]]"#;
        assert_eq!(told(second), (some("W (x)", Some(32723)), None));
        assert_eq!(told(r#"GEOGCS["WGS 84",AUTHORITY["ESRI","104"]]"#), (some("WGS 84", None), None));
    }

    #[test]
    fn nonsense_gives_nothing_or_little() {
        assert_eq!(told(""), (None, None));
        assert_eq!(told("PROJCS"), (None, None));
        assert_eq!(told("PROJCS["), (some("", None), None));
        assert_eq!(told(r#"PROJCS["unclosed"#), (some("unclosed", None), None));
        assert_eq!(told(r#"]]]"PROJCS["é"["#), (None, None));
    }

    proptest::proptest! {
        #[test]
        fn any_text_comes_to_an_end(text in "(PROJCS|VERT_CS|AUTHORITY|EPSG|[\\[\\]()\",é 1])*") {
            let (horizontal, vertical) = told(&text);
            proptest::prop_assert!(horizontal.is_none_or(|h| text.contains("PROJCS") && text.contains(&h.name)));
            proptest::prop_assert!(vertical.is_none_or(|v| text.contains("VERT_CS") && text.contains(&v.name)));
        }
    }

    #[test]
    fn units_of_projected_systems() {
        let wkt1 = r#"PROJCS["a",GEOGCS["g",SPHEROID["s",6378137,298.2],UNIT["degree",0.0174]],PARAMETER["p",9],
            UNIT["US survey foot",0.304800609601219,AUTHORITY["EPSG","9003"]],AXIS["x",EAST]]"#;
        let wkt2 = r#"PROJCRS["a",BASEGEOGCRS["g",DATUM["d",ELLIPSOID["e",6378137,298.2,LENGTHUNIT["metre",1]]]],
            CS[Cartesian,2],AXIS["(E)",east,ORDER[1],LENGTHUNIT["foot",0.3048]]]"#;
        let degrees = r#"GEOGCS["g",SPHEROID["s",6378137,298.2],UNIT["degree",0.0174]]"#;
        assert_eq!(metres_per_unit(wkt1), Some(0.304800609601219));
        assert_eq!(metres_per_unit(wkt2), Some(0.3048));
        assert_eq!([degrees, "", "PROJCS[", r#"PROJCS["a",UNIT["x",-1]]"#].map(metres_per_unit), [None; 4]);
    }
}
