// Colours of the points of the bound page. Twin: `FileColor::color` in src/render/color.rs.
@group(1) @binding(2) var<storage, read> attributes: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> records: array<u32>;

struct FileColor {
    first_record: u32,
    kind: u32,
    low: u32,
    high: u32,
}
@group(3) @binding(0) var<storage, read> files: array<FileColor>;
// A uniform: with the sums there is no room for a ninth storage buffer, more than which WebGPU does not promise.
struct ColorTables {
    // Four to a vector, for a uniform's arrays have no smaller step.
    thresholds: array<vec4<u32>, 64>,
    // 256 colours, red in the lowest byte.
    ramp: array<vec4<u32>, 64>,
}
@group(3) @binding(1) var<uniform> tables: ColorTables;

// `NO_DATA` in src/render/color.rs.
const NO_DATA: u32 = 0x6e6e6eu;

// The last threshold that `key` reaches. Twin: `level` in src/render/scale.rs.
fn level_of(key: u32) -> u32 {
    var at = 0u;
    for (var step = 128u; step > 0u; step >>= 1u) {
        let next = at + step;
        at = select(at, next, tables.thresholds[next / 4u][next % 4u] <= key);
    }
    return at;
}

fn ramp_color(at: u32) -> u32 {
    return tables.ramp[at / 4u][at % 4u] & 0xffffffu;
}

fn share_of(above: u32, range: u32) -> u32 {
    if range == 0u {
        return 0u;
    }
    return u32(min(f32(above) / f32(range), 1.0) * 255.0 + 0.5);
}

fn grey(above: u32, range: u32) -> u32 {
    let share = select(min(f32(above) / f32(range), 1.0), 0.0, range == 0u);
    return u32(sqrt(share) * 223.0 + 32.5);
}

fn grey_of(file: FileColor, attributes: vec2<u32>) -> u32 {
    let intensity = attributes.y >> 16u;
    return grey(intensity - min(intensity, file.low), file.high - file.low);
}

// The file of a record: the last one that begins at or before it.
fn file_of(record: u32) -> FileColor {
    var low = 0u;
    var high = arrayLength(&files);
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if files[middle].first_record <= record {
            low = middle;
        } else {
            high = middle;
        }
    }
    return files[low];
}

// `attributes` holds 16-bit red, green, blue and intensity. The position is read where it is needed only: a random read
// less per pixel.
fn point_color(file: FileColor, attributes: vec2<u32>, local: u32) -> u32 {
    let rgb = vec3<u32>(attributes.x & 0xffffu, attributes.x >> 16u, attributes.y & 0xffffu);
    switch file.kind {
        case 0u: {
            return (rgb.x >> 8u) | (rgb.y & 0xff00u) | ((rgb.z & 0xff00u) << 8u);
        }
        case 1u: {
            return (rgb.x & 0xffu) | ((rgb.y & 0xffu) << 8u) | ((rgb.z & 0xffu) << 16u);
        }
        case 2u: {
            return grey_of(file, attributes) * 0x10101u;
        }
        case 4u: {
            return level_of(rgb.x) | (level_of(rgb.y) << 8u) | (level_of(rgb.z) << 16u);
        }
        case 5u: {
            let wide = (rgb & vec3<u32>(0xffu)) * 257u;
            return level_of(wide.x) | (level_of(wide.y) << 8u) | (level_of(wide.z) << 16u);
        }
        case 6u: {
            return level_of(grey_of(file, attributes) * 257u) * 0x10101u;
        }
        case 7u: {
            return ramp_color(level_of((attributes.y >> 16u) + 1u));
        }
        case 8u: {
            return ramp_color(level_of(bitcast<u32>(load_position(local).z) ^ 0x80000000u));
        }
        case 9u: {
            return file.low;
        }
        default: {
            let z = load_position(local).z;
            let above = bitcast<u32>(max(z, bitcast<i32>(file.low))) - file.low;
            return ramp_color(share_of(above, file.high - file.low));
        }
    }
}

// Red in the lowest byte; `local` counts from the page's first slot.
fn color_of(local: u32) -> u32 {
    // With one file nobody asks for the record: a random read less per pixel.
    var file = files[0];
    if arrayLength(&files) > 1u {
        file = file_of(records[local]);
    }
    return point_color(file, attributes[local], local);
}
