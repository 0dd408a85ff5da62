//! What scanner channels do to a layer: each of the four has models and a last value of its own, and
//! takes the last value over from another one when its first point comes.

use super::super::model::Model;

/// Which context a point uses: whose models, and whose last value; and whose last value the context
/// starts with, if this is its first point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    pub context: u8,
    pub last: u8,
    pub from: Option<u8>,
}

impl Entry {
    const BITS: u32 = 7;

    fn packed(self) -> u32 {
        let from = self.from.map_or(0, |from| 4 | u32::from(from & 3));
        u32::from(self.context & 3) | u32::from(self.last & 3) << 2 | from << 4
    }

    #[inline(always)]
    fn unpacked(bits: u32) -> Entry {
        let from = (bits >> 4 & 4 != 0).then_some((bits >> 4 & 3) as u8);
        Entry { context: (bits & 3) as u8, last: (bits >> 2 & 3) as u8, from }
    }
}

/// What the first layer says about a point, and the other layers' contexts need to know.
#[derive(Debug, Clone, Copy, Default)]
pub struct Facts(u32);

impl Facts {
    /// `changes` as the first layer has them; `level` below 8, `z_context` below 20.
    #[inline(always)]
    pub fn new(changes: u32, first: bool, last: bool, level: u8, z_context: u32) -> Facts {
        let changed = (changes >> 3) & 7;
        let place = u32::from(first) << 1 | u32::from(last);
        Facts(changed | place << 3 | u32::from(level & 7) << 5 | (z_context & 31) << 8)
    }

    /// With the contexts of the point's own layers, and of the other items'.
    #[inline(always)]
    pub fn with_entries(self, point: Entry, item: Entry) -> Facts {
        Facts(self.0 | point.packed() << 13 | item.packed() << (13 + Entry::BITS))
    }

    #[inline(always)]
    pub fn angle_changed(self) -> bool {
        self.0 & 1 != 0
    }

    #[inline(always)]
    pub fn time_changed(self) -> bool {
        self.0 & 2 != 0
    }

    #[inline(always)]
    pub fn source_changed(self) -> bool {
        self.0 & 4 != 0
    }

    /// 3: single return, 2: first of many, 1: last, 0: between.
    #[inline(always)]
    pub fn place(self) -> usize {
        (self.0 >> 3 & 3) as usize
    }

    /// Number of returns and return number as one of 8 classes.
    #[inline(always)]
    pub fn level(self) -> usize {
        (self.0 >> 5 & 7) as usize
    }

    #[inline(always)]
    pub fn z_context(self) -> u32 {
        self.0 >> 8 & 31
    }

    #[inline(always)]
    pub fn point(self) -> Entry {
        Entry::unpacked(self.0 >> 13)
    }

    #[inline(always)]
    pub fn item(self) -> Entry {
        Entry::unpacked(self.0 >> (13 + Entry::BITS))
    }
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

    /// A point's context, and the last value, to be replaced.
    #[inline(always)]
    pub fn enter(&mut self, entry: Entry) -> (&mut C, &mut V) {
        let context = usize::from(entry.context & 3);
        if entry.from.is_some() || self.contexts[context].is_none() {
            self.begin(entry);
        }
        let last = &mut self.last[usize::from(entry.last & 3)];
        (self.contexts[context].get_or_insert_with(|| Box::new(C::start(last))), last)
    }

    #[cold]
    #[inline(never)]
    fn begin(&mut self, entry: Entry) {
        let context = usize::from(entry.context & 3);
        if let Some(from) = entry.from {
            self.last[context] = self.last[usize::from(from & 3)];
        }
        self.contexts[context] = Some(Box::new(C::start(&self.last[context])));
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
