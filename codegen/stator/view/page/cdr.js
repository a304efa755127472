// Reads a sample in CDR (little-endian, each value at a multiple of its size behind the head).
const SIZES = {bool: 1, int8: 1, uint8: 1, int16: 2, uint16: 2, int32: 4, uint32: 4, float: 4, int64: 8, uint64: 8, double: 8};
const HEAD = 4;

export function decode(fields, view, start) {
    const found = {};
    let at = 0;
    for (const field of fields) {
        const size = SIZES[field.type];
        at = Math.ceil(at / size) * size;
        const values = [];
        for (let i = 0; i < (field.count ?? 1); ++i, at += size) {
            values.push(at + size + HEAD + start <= view.byteLength ? read(view, start + HEAD + at, field.type) : NaN);
        }
        found[field.name] = field.count === null ? values[0] : values;
    }
    return found;
}

function read(view, at, type) {
    switch (type) {
        case 'bool': return view.getUint8(at) !== 0;
        case 'int8': return view.getInt8(at);
        case 'uint8': return view.getUint8(at);
        case 'int16': return view.getInt16(at, true);
        case 'uint16': return view.getUint16(at, true);
        case 'int32': return view.getInt32(at, true);
        case 'uint32': return view.getUint32(at, true);
        case 'int64': return Number(view.getBigInt64(at, true));
        case 'uint64': return Number(view.getBigUint64(at, true));
        case 'float': return view.getFloat32(at, true);
        default: return view.getFloat64(at, true);
    }
}
