// The generated table of what is logged. The logger is a reader like any other; as it handles
// samples of every type alike, it sees them as bytes.
#pragma once

#include <cstdint>

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
    const char* name;
    const char* format;  // fields as ULog spells them
    const Topic* topic;
    LogCursor* cursor;
    const FloatRun* floats;
    uint16_t float_count;
    uint16_t bytes;        // of a sample, without padding at its end
    uint32_t interval_us;  // 0: every sample
};

struct LogParameter {
    const char* name;  // NODE.PARAMETER
    bool is_float;     // else int32
    float float_value;
    int32_t int32_value;
};

// What the log says of parameters that can change.
struct LogChanges {
    const ParameterTable* table;
    ParameterBits* logged;  // by row
    uint32_t* seen;         // by topic: the number of the sample; 0 before the first
};

struct LogTable {
    const LogTopic* topics;
    uint32_t topic_count;
    const LogParameter* parameters;
    uint32_t parameter_count;
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

// Takes the next sample to log at `now_us`; false if there is none. Release with `release`.
inline bool take_logged(const LogTopic& row, uint64_t now_us, Pin& pin) {
    LogCursor& cursor = *row.cursor;
    if (row.interval_us == 0) return take_next(*row.topic, cursor.number, cursor.lost, pin);
    if (now_us < cursor.due_us || !has_unread(*row.topic, cursor.number)) return false;
    if (!take_latest(*row.topic, cursor.number, pin)) return false;
    cursor.number = number_of(*row.topic, pin);
    cursor.due_us += ((now_us - cursor.due_us) / row.interval_us + 1) * row.interval_us;
    return true;
}

}  // namespace stator
