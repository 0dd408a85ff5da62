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
// 256 colours, red in the lowest byte. A uniform: with the sums there is no room for a ninth storage
// buffer, more than which WebGPU does not promise.
@group(3) @binding(1) var<uniform> ramp: array<vec4<u32>, 64>;

fn level(above: u32, range: u32) -> u32 {
    if range == 0u {
        return 0u;
    }
    return u32(min(f32(above) / f32(range), 1.0) * 255.0 + 0.5);
}

fn grey(above: u32, range: u32) -> u32 {
    let share = select(min(f32(above) / f32(range), 1.0), 0.0, range == 0u);
    return u32(sqrt(share) * 223.0 + 32.5);
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

// `attributes` holds 16-bit red, green, blue and intensity.
fn point_color(file: FileColor, attributes: vec2<u32>, z: i32) -> u32 {
    let rgb = vec3<u32>(attributes.x & 0xffffu, attributes.x >> 16u, attributes.y & 0xffffu);
    switch file.kind {
        case 0u: {
            return (rgb.x >> 8u) | (rgb.y & 0xff00u) | ((rgb.z & 0xff00u) << 8u);
        }
        case 1u: {
            return (rgb.x & 0xffu) | ((rgb.y & 0xffu) << 8u) | ((rgb.z & 0xffu) << 16u);
        }
        case 2u: {
            let intensity = attributes.y >> 16u;
            return grey(intensity - min(intensity, file.low), file.high - file.low) * 0x10101u;
        }
        default: {
            let above = bitcast<u32>(max(z, bitcast<i32>(file.low))) - file.low;
            let at = level(above, file.high - file.low);
            return ramp[at / 4u][at % 4u] & 0xffffffu;
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
    return point_color(file, attributes[local], load_position(local).z);
}
