// Which points of the bound page a filter hides by what is with the points, from integers alone.
// Twin: `MaskRules::show` in src/render/filter/rules.rs.
fn magnitude(a: u32) -> u32 {
    return select(a, 0u - a, a >= HIGHEST_BIT);
}

// Of two numbers with signs.
fn product(a: u32, b: u32) -> vec2<u32> {
    let x = magnitude(a);
    let y = magnitude(b);
    let low = (x & 0xffffu) * (y & 0xffffu);
    let cross = (x >> 16u) * (y & 0xffffu) + (low >> 16u);
    let middle = (x & 0xffffu) * (y >> 16u) + (cross & 0xffffu);
    let high = (x >> 16u) * (y >> 16u) + (cross >> 16u) + (middle >> 16u);
    let positive = vec2<u32>((middle << 16u) | (low & 0xffffu), high);
    let negative = sum(~positive, vec2<u32>(1u, 0u));
    return select(positive, negative, ((a ^ b) & HIGHEST_BIT) != 0u);
}

fn key_of(test: u32, local: u32) -> vec2<u32> {
    switch rules[test] {
        case 0u, 1u, 2u: {
            return vec2<u32>(bitcast<u32>(load_position(local)[rules[test]]) ^ HIGHEST_BIT, 0u);
        }
        case 3u: {
            let p = bitcast<vec3<u32>>(load_position(local));
            let x = product(rules[test + 1u], p.x);
            let dot = sum(sum(x, product(rules[test + 2u], p.y)), product(rules[test + 3u], p.z));
            return vec2<u32>(dot.x, dot.y ^ HIGHEST_BIT);
        }
        case 4u: {
            return vec2<u32>(attributes[local].y >> 16u, 0u);
        }
        default: {
            return vec2<u32>(records[local], 0u);
        }
    }
}

// All bits are made anew.
const KEEPS_BITS: bool = false;

fn hides(local: u32) -> bool {
    for (var t = 0u; t < rules[0]; t++) {
        let test = FIRST_TEST + RULE_WORDS * t;
        if !is_in_range(test, key_of(test, local)) {
            return true;
        }
    }
    return false;
}

// Adds up the bits.
@compute @workgroup_size(256)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let word = line_index(group, groups, thread);
    if word < arrayLength(&hidden) {
        atomicAdd(&bits[0], countOneBits(atomicLoad(&hidden[word])));
    }
    workgroupBarrier();
    if thread == 0u {
        atomicAdd(&hidden_points, atomicLoad(&bits[0]));
    }
}
