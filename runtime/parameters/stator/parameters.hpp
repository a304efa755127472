// The generated table of all parameters of a graph. Nodes read theirs as a message; the node that
// changes and logs them handles those of all nodes alike, as bytes.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace stator {

struct Topic;

enum class ParameterType : uint8_t { kFloat, kInt32, kBool };

// A value of any type: a float or an int32 bit by bit; a bool as 0 or 1.
using ParameterBits = uint32_t;

struct ParameterName {
    const char* name;     // NODE.PARAMETER
    const char* id;       // for ground stations: at most 16 characters
    uint32_t key;         // of its record: the CRC-32 of the name
    uint32_t definition;  // the CRC-32 of type and unit
};

struct ParameterRow {
    ParameterName is;
    ParameterBits least;
    ParameterBits most;
    ParameterBits standard;  // the graph's value, which counts at the start
    uint16_t offset;         // in the message of its node's parameters
    uint8_t topic;           // its place among the topics of the table
    ParameterType type;
    bool is_fixed = false;   // while the graph runs
    bool on_ground = false;  // it changes only while the vehicle is disarmed
};

// Rows as the generated table spells them.
namespace parameter {
constexpr ParameterRow real(ParameterName is, uint8_t topic, uint16_t offset, float least,
                            float most, float standard) {
    return {.is = is,
            .least = std::bit_cast<ParameterBits>(least),
            .most = std::bit_cast<ParameterBits>(most),
            .standard = std::bit_cast<ParameterBits>(standard),
            .offset = offset,
            .topic = topic,
            .type = ParameterType::kFloat};
}
constexpr ParameterRow whole(ParameterName is, uint8_t topic, uint16_t offset, int32_t least,
                             int32_t most, int32_t standard) {
    return {.is = is,
            .least = std::bit_cast<ParameterBits>(least),
            .most = std::bit_cast<ParameterBits>(most),
            .standard = std::bit_cast<ParameterBits>(standard),
            .offset = offset,
            .topic = topic,
            .type = ParameterType::kInt32};
}
constexpr ParameterRow flag(ParameterName is, uint8_t topic, uint16_t offset, bool standard) {
    return {.is = is,
            .least = 0,
            .most = 1,
            .standard = standard ? 1U : 0U,
            .offset = offset,
            .topic = topic,
            .type = ParameterType::kBool};
}
constexpr ParameterRow on_ground(ParameterRow row) {
    row.on_ground = true;
    return row;
}
constexpr ParameterRow fixed(ParameterRow row) {
    row.is_fixed = true;
    return row;
}
}  // namespace parameter

// Of a row, in a sample of its topic.
inline ParameterBits read_parameter(const ParameterRow& row, const void* sample) {
    const auto* from = static_cast<const std::byte*>(sample) + row.offset;
    if (row.type == ParameterType::kBool) return std::to_integer<ParameterBits>(*from);
    ParameterBits value = 0;
    std::memcpy(&value, from, sizeof value);
    return value;
}
inline void write_parameter(const ParameterRow& row, void* sample, ParameterBits value) {
    auto* to = static_cast<std::byte*>(sample) + row.offset;
    if (row.type == ParameterType::kBool) {
        *to = static_cast<std::byte>(value);
    } else {
        std::memcpy(to, &value, sizeof value);
    }
}

// The parameters of one node. `keep`: as in one_core_topic.hpp.
struct ParameterTopic {
    const Topic* topic;
    bool keep;
};

// A record that a parameter had under another name.
struct FormerParameter {
    uint32_t key;
    uint16_t row;
};

struct ParameterTable {
    const ParameterRow* rows;  // in the order of their ids
    uint32_t row_count;
    const FormerParameter* former = nullptr;
    uint32_t former_count = 0;
    const ParameterTopic* topics = nullptr;  // none in a replay
    uint32_t topic_count = 0;
};

extern const ParameterTable parameter_table;  // generated, where a node publishes parameters

}  // namespace stator
