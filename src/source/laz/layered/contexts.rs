//! What scanner channels do to a layer: each of the four has models and a last value of its own, and
//! takes both over from another one when its first point comes.

use super::super::{coder::Coder, model::Model};
use super::stream::Layer;

/// Points of a block that follow each other and use the same context.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// Number within the block of the point behind its last one.
    pub end: usize,
    /// Whose models are used, and whose last value: 0 to 3.
    pub context: u8,
    pub last: u8,
    /// The context whose last value this one starts with, if this is its first run.
    pub from: Option<u8>,
}

/// What the first layer says about the other layers' points: facts, one per point, and runs.
pub struct Block<'a> {
    pub record_length: usize,
    pub facts: &'a [Facts],
    pub runs: &'a [Run],
}

/// What other layers' contexts need to know of a point.
#[derive(Debug, Clone, Copy, Default)]
pub struct Facts(u16);

impl Facts {
    /// `z_context` is below 20, `level` below 8.
    pub fn new(changes: u32, first: bool, last: bool, level: u8, z_context: u32) -> Facts {
        let changed = (changes >> 3) & 7;
        let place = u32::from(first) << 1 | u32::from(last);
        Facts((changed | place << 3 | u32::from(level & 7) << 5 | (z_context & 31) << 8) as u16)
    }

    pub fn angle_changed(self) -> bool {
        self.0 & 1 != 0
    }

    pub fn time_changed(self) -> bool {
        self.0 & 2 != 0
    }

    pub fn source_changed(self) -> bool {
        self.0 & 4 != 0
    }

    /// 3: single return, 2: first of many, 1: last, 0: between.
    pub fn place(self) -> usize {
        usize::from(self.0 >> 3 & 3)
    }

    /// Number of returns and return number as one of 8 classes.
    pub fn level(self) -> usize {
        usize::from(self.0 >> 5 & 7)
    }

    pub fn z_context(self) -> u32 {
        u32::from(self.0 >> 8)
    }
}

/// A decoder of one layer.
pub trait Field: Send {
    /// The most bytes that one point takes: two per symbol, one per raw byte begun.
    fn most_bytes(&self) -> usize;

    /// Decodes a block's points into its records; returns their number, smaller than the block's if
    /// the bytes ended.
    fn decode(&mut self, layer: &mut Layer, block: &Block<'_>, records: &mut [u8]) -> usize;

    fn memory_bytes(&self) -> usize;
}

/// What a context holds besides the last value.
pub trait Context<V> {
    /// A context's state before its first point.
    fn start(last: &V) -> Self;

    fn memory_bytes(&self) -> usize;
}

/// The contexts of a layer, made when first used: most scanners have one channel.
pub struct Contexts<C, V> {
    contexts: [Option<Box<C>>; 4],
    last: [V; 4],
}

impl<C: Context<V>, V: Copy> Contexts<C, V> {
    /// Before the second point of a chunk: the first one had this value, in this context.
    pub fn new(first: V, context: usize) -> Self {
        let mut contexts = [const { None }; 4];
        contexts[context & 3] = Some(Box::new(C::start(&first)));
        Contexts { contexts, last: [first; 4] }
    }

    /// Decodes a block, point by point: `point` gets the context, the last value (to be replaced) and
    /// the facts, and writes into the record.
    #[inline(always)]
    pub fn decode(
        &mut self,
        layer: &mut Layer,
        block: &Block<'_>,
        records: &mut [u8],
        mut point: impl FnMut(&mut C, &mut V, &mut Coder, &[u8], Facts, &mut [u8]),
    ) -> usize {
        let (mut coder, bytes) = layer.take();
        let mut done = 0;
        'runs: for run in block.runs {
            let (context, last) = (usize::from(run.context & 3), usize::from(run.last & 3));
            if let Some(from) = run.from {
                self.last[context] = self.last[usize::from(from & 3)];
                self.contexts[context] = None;
            }
            let last = &mut self.last[last];
            let context = self.contexts[context].get_or_insert_with(|| Box::new(C::start(last)));
            let Some(facts) = block.facts.get(done..run.end) else { break };
            let records = records[done * block.record_length..].chunks_exact_mut(block.record_length);
            for (record, &facts) in records.zip(facts) {
                point(context, last, &mut coder, bytes, facts, record);
                if coder.next() > bytes.len() {
                    break 'runs;
                }
                done += 1;
            }
        }
        layer.put_back(coder);
        done
    }

    pub fn memory_bytes(&self) -> usize {
        self.contexts.iter().flatten().map(|c| size_of::<C>() + c.memory_bytes()).sum()
    }
}

/// A model that is made when its first symbol comes.
pub type Lazy = Option<Box<Model>>;

/// The model, made now if it wasn't yet.
#[inline]
pub fn made(model: &mut Lazy, symbols: u32) -> &mut Model {
    model.get_or_insert_with(|| Box::new(Model::new(symbols)))
}

/// Heap bytes of models.
pub fn models_bytes<'a>(models: impl IntoIterator<Item = &'a Lazy>) -> usize {
    models.into_iter().flatten().map(|m| size_of::<Model>() + m.memory_bytes()).sum()
}

/// Writes a value of two bytes into a record.
#[inline]
pub fn put_u16(record: &mut [u8], at: usize, value: u16) {
    record[at..at + 2].copy_from_slice(&value.to_le_bytes());
}

/// Writes a value of four bytes into a record.
#[inline]
pub fn put_i32(record: &mut [u8], at: usize, value: i32) {
    record[at..at + 4].copy_from_slice(&value.to_le_bytes());
}
