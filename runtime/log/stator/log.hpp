// The generated table of what is logged. The logger is a reader like any other; as it handles
// samples of every type alike, it sees them as bytes.
#pragma once

#include <bit>
#include <cstdint>
#include <string_view>

#include "stator/events.hpp"
#include "stator/parameters.hpp"
#include "stator/recording.hpp"
#include "stator/start_values.hpp"
#include "stator/topic.hpp"

namespace stator {

// Where the logger stands in one topic.
struct LogCursor {
    uint32_t number = 0;
    uint32_t lost = 0;
    uint64_t due_us = 0;
};

struct LogTopic {
    std::string_view name;
    std::string_view format;  // fields as ULog spells them
    const Topic* topic;
    LogCursor* cursor;
    const FloatRun* floats;
    uint16_t float_count;
    uint16_t bytes;        // of a sample, without padding at its end
    uint32_t interval_us;  // 0: every sample
};

struct LogParameter {
    std::string_view name;  // NODE.PARAMETER
    bool is_float;          // else int32
    ParameterBits value;
};

// What the log says of parameters that can change.
struct LogChanges {
    const ParameterTable* table;
    ParameterBits* logged;  // by row: how the newest logged value differs from the graph's
    uint32_t* seen;         // by topic: the number of the sample; 0 before the first
};

struct LogTable {
    const LogTopic* topics;
    uint32_t topic_count;
    const LogParameter* parameters;
    uint32_t parameter_count;
    uint32_t blocks_at_once;              // at most, of one activation without a recording
    const StartValues* start = nullptr;   // the same parameters, where an option may replace them
    const LogChanges* changes = nullptr;  // none where parameters are fixed
    const LogEvents* events;
    const char* graph;       // name
    const char* graph_hash;  // of what behaves; DESIGN 8
#ifdef STATOR_RECORDING
    const RecordingTable* recording = nullptr;
#else
    // A constant, so that none of its code is left. NOLINTNEXTLINE(readability-identifier-naming)
    static constexpr const RecordingTable* recording = nullptr;
#endif
};

extern const LogTable log_table;  // generated, where the graph has a logger

// Samples that passed before the logger came to read them, modulo 2^32.
inline uint32_t lost_samples(const LogTable& table) {
    uint32_t lost = 0;
    for (uint32_t i = 0; i < table.topic_count; ++i) lost += table.topics[i].cursor->lost;
    return lost;
}

// Takes the next sample to log at `now_us`; false if there is none. Release with `release`. Samples
// that passed before the first one that is taken are not lost: the log begins after them.
inline bool take_logged(const LogTopic& row, uint64_t now_us, Pin& pin) {
    LogCursor& cursor = *row.cursor;
    if (row.interval_us == 0) {
        const bool is_first = cursor.number == 0;
        if (!take_next(*row.topic, cursor.number, cursor.lost, pin)) return false;
        if (is_first) cursor.lost = 0;
        return true;
    }
    if (now_us < cursor.due_us || !has_unread(*row.topic, cursor.number)) return false;
    if (!take_latest(*row.topic, cursor.number, pin)) return false;
    cursor.number = number_of(*row.topic, pin);
    cursor.due_us += ((now_us - cursor.due_us) / row.interval_us + 1) * row.interval_us;
    return true;
}

}  // namespace stator
