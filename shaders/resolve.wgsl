// From slots to colours, for the points of the bound page. Twin: `FileColor::color` in
// src/render/color.rs.
@group(0) @binding(1) var<storage, read> words: array<vec2<u32>>;

@group(1) @binding(2) var<storage, read> attributes: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> records: array<u32>;

struct FileColor {
    first_record: u32,
    kind: u32,
    low: u32,
    high: u32,
}
@group(2) @binding(0) var<storage, read> files: array<FileColor>;
// 256 colours, red in the lowest byte.
@group(2) @binding(1) var<storage, read> ramp: array<u32>;
// Red in the lowest byte, alpha 255.
@group(2) @binding(2) var<storage, read_write> colors: array<u32>;
@group(2) @binding(3) var<storage, read_write> shown_records: array<u32>;

const NONE: u32 = 0xffffffffu;
const OPAQUE: u32 = 0xff000000u;

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
            return ramp[level(above, file.high - file.low)] & 0xffffffu;
        }
    }
}

fn shown_slot(pixel: u32) -> u32 {
    if pixel >= view.width * view.height || words[pixel].x == NONE {
        return NONE;
    }
    return words[pixel].x - page.first;
}

@compute @workgroup_size(256)
fn color(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    let slot = shown_slot(pixel);
    if slot < page.len {
        // With one file nobody asks for the record: a random read less per pixel.
        var file = files[0];
        if arrayLength(&files) > 1u {
            file = file_of(records[slot]);
        }
        colors[pixel] = point_color(file, attributes[slot], load_position(slot).z) | OPAQUE;
    }
}

// Which record each pixel shows, for a picture that is read back.
@compute @workgroup_size(256)
fn identify(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    let slot = shown_slot(pixel);
    if slot < page.len {
        shown_records[pixel] = records[slot];
    }
}
