// The generated files that describe a graph's parameters to ground stations: MAVLink's component
// metadata.
#pragma once

#include <cstdint>
#include <span>

namespace stator {

struct MetadataFile {
    const uint8_t* data;
    uint32_t bytes;
    uint32_t crc;  // without the inversions before and after, as MAVLink's file transfer has it

    std::span<const uint8_t> all() const { return {data, bytes}; }
};

struct Metadata {
    MetadataFile general;     // general.json, which names the other
    MetadataFile parameters;  // parameters.json.xz
};

// In the images of graphs with a node that reads it.
extern const Metadata metadata;

}  // namespace stator
