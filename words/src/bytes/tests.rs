use super::*;

const MAGIC: &[u8; 8] = b"mnsctst2";

/// A state with a field of every kind.
#[derive(Clone, Debug, PartialEq)]
struct Sample {
    tag: bool,
    version: u32,
    counts: [u64; 2],
    width: usize,
    numbers: [f64; 3],
    nested: Vec<u8>,
    token: String,
    ids: Vec<u32>,
    pressures: Vec<f64>,
    positions: Vec<[f64; 3]>,
    columns: Vec<Vec<f64>>,
    memory: [Option<f64>; 2],
}

fn sample() -> Sample {
    Sample {
        tag: true,
        version: u32::MAX,
        counts: [0, u64::MAX],
        width: 7,
        numbers: [-0.0, f64::MIN_POSITIVE / 2.0, f64::INFINITY],
        nested: vec![1, 2, 3],
        token: "{é}".into(),
        ids: vec![3, 1],
        pressures: vec![1.5, -2.5],
        positions: vec![[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]],
        columns: vec![vec![], vec![1.0, 2.0]],
        memory: [None, Some(0.5)],
    }
}

fn to_bytes(sample: &Sample) -> Vec<u8> {
    let mut state = Writer::new(MAGIC);
    state.bool(sample.tag);
    state.u32(sample.version);
    sample.counts.iter().for_each(|count| state.u64(*count));
    state.usize(sample.width);
    sample.numbers.iter().for_each(|number| state.f64(*number));
    state.bytes(&sample.nested);
    state.text(&sample.token);
    state.u32s(&sample.ids);
    state.f64s(&sample.pressures);
    state.vectors(&sample.positions);
    state.list(&sample.columns, |state, column| state.f64s(column));
    sample.memory.iter().for_each(|value| state.option(value.as_ref(), |state, x| state.f64(*x)));
    state.finish()
}

fn from_bytes(bytes: &[u8]) -> Result<Sample, Error> {
    let mut state = Reader::new("sample", MAGIC, bytes)?;
    let sample = Sample {
        tag: state.bool("tag")?,
        version: state.u32("version")?,
        counts: [state.u64("first count")?, state.u64("second count")?],
        width: state.usize("width")?,
        numbers: [state.f64("number")?, state.f64("number")?, state.f64("number")?],
        nested: state.bytes("nested state")?.to_vec(),
        token: state.text("token")?.to_owned(),
        ids: state.u32s("ids", Some(2))?,
        pressures: state.f64s("pressures", None)?,
        positions: state.vectors("positions", Some(2))?,
        columns: state.list("columns", None, |state| state.f64s("column", None))?,
        memory: [
            state.option("memory", |state| state.f64("remembered"))?,
            state.option("memory", |state| state.f64("remembered"))?,
        ],
    };
    state.finish()?;
    Ok(sample)
}

#[test]
fn a_state_comes_back_to_the_bit() {
    let read = from_bytes(&to_bytes(&sample())).unwrap();
    assert_eq!(read, sample());
    assert_eq!(read.numbers.map(f64::to_bits), sample().numbers.map(f64::to_bits));
}

#[test]
fn a_state_cut_off_anywhere_is_refused() {
    let bytes = to_bytes(&sample());
    for length in 0..bytes.len() {
        let problem = from_bytes(&bytes[..length]).unwrap_err().problem;
        match problem {
            Problem::Magic { .. } => assert!(length < 8, "{length}"),
            Problem::Cut { at, needed, left, .. } => {
                assert!(at <= length && left < needed, "{length}: {at}, {needed}, {left}");
            }
            other => panic!("{length}: {other}"),
        }
    }
}

#[test]
fn what_follows_a_state_is_refused() {
    let bytes = to_bytes(&sample());
    let longer = [&bytes[..], &[0]].concat();
    let problem = Problem::Trailing { at: bytes.len(), left: 1 };
    assert_eq!(from_bytes(&longer), Err(Error { state: "sample", problem }));
}

#[test]
fn another_magic_and_another_version_are_told_apart() {
    let bytes = to_bytes(&sample());
    let said = |start: &[u8; 8]| {
        let bytes = [start, &bytes[8..]].concat();
        from_bytes(&bytes).unwrap_err().to_string()
    };
    assert_eq!(said(b"mnsctst1"), "the sample is of version 1, where 2 is read");
    assert_eq!(said(b"mnscoth2"), "the sample does not start with \"mnsctst2\"");
}

/// Nothing is reserved for a count that the bytes left cannot hold: these would take more than any memory.
#[test]
fn absurd_counts_are_refused_before_anything_is_reserved() {
    let with_count = |count: u64| {
        let mut state = Writer::new(MAGIC);
        state.u64(count);
        state.f64(0.0);
        state.finish()
    };
    for count in [9, 1 << 40, u64::MAX / 8, u64::MAX / 8 + 2, u64::MAX] {
        let bytes = with_count(count);
        let reader = || Reader::new("sample", MAGIC, &bytes).unwrap();
        let problems = [
            reader().bytes("field").unwrap_err().problem,
            reader().text("field").unwrap_err().problem,
            reader().u32s("field", None).unwrap_err().problem,
            reader().f64s("field", None).unwrap_err().problem,
            reader().vectors::<3, [f64; 3]>("field", None).unwrap_err().problem,
            reader().list("field", None, |state| state.u8("entry")).unwrap_err().problem,
        ];
        for problem in problems {
            assert!(matches!(problem, Problem::Cut { at: 8, left: 8, .. }), "{count}: {problem}");
        }
        let problem = Problem::Count { field: "field", at: 8, found: count, expected: 1 };
        assert_eq!(reader().f64s("field", Some(1)).unwrap_err().problem, problem);
    }
}

#[test]
fn values_that_cannot_be_are_refused_where_they_stand() {
    let mut state = Writer::new(MAGIC);
    state.u8(2);
    state.bytes(&[0xff]);
    let bytes = state.finish();
    let mut state = Reader::new("sample", MAGIC, &bytes).unwrap();
    let said = state.bool("flag").unwrap_err().to_string();
    assert_eq!(said, "the sample holds 2 at byte 8, which its flag cannot be");
    assert_eq!(
        state.text("token").unwrap_err().to_string(),
        "the sample holds no UTF-8 at byte 9, which its token cannot be"
    );
}
