// What a node may see of the graph that it is part of: figures of its tasks, and the newest samples
// of its topics. Not recorded, so a replay does not run such a node.
#pragma once

#include <cstddef>
#include <cstdint>

#include "stator/task.hpp"

namespace stator {

struct ObservedTask {
    const char* name;
    const TaskCounters* counters;
    uint16_t index;
    uint8_t level;
};

struct ObservedTopic {
    const char* name;
    const char* format;  // fields as ULog spells them
    const Topic* topic;
    uint16_t bytes;  // of a sample, without padding at its end
};

struct GraphTable {
    const ObservedTask* tasks;  // most urgent first
    uint32_t task_count;
    const ObservedTopic* topics;  // by name
    uint32_t topic_count;
};

extern const GraphTable graph_table;  // generated, where a node reads it

// --- of each executor; context: a task of the lowest level ---

// What a task has counted, as it was between two activations.
TaskCounters figures_of(const ObservedTask& task);
// Ticks in a second; 0: execution times are not measured.
uint32_t observed_ticks_hz();
// Copies at most `bytes` of a topic's newest sample, and says its number. False: there is none, or
// publications came in between again and again.
bool copy_newest(const Topic& topic, uint8_t* to, size_t bytes, uint32_t& number);

}  // namespace stator
