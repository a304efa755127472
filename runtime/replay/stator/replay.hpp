// What a replayed task sees of the recording: its activation, with what it took and published.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "stator/canonical.hpp"

namespace stator::replay {

class Replay;

struct Taken {
    const void* sample = nullptr;  // none: nothing (more) was taken
    uint32_t number = 0;
};

// A recorded activation that runs again.
class Job {
  public:
    uint64_t now_us() const { return now_us_; }
    uint32_t timers() const { return static_cast<uint32_t>(fired_ >> 1); }
    // The node was constructed anew before it; `start` says where its i-th trigger or queue began.
    bool is_anew() const { return (fired_ & 1U) != 0; }
    uint32_t start(size_t i) const { return starts_[i]; }

    // The next sample that the port took.
    Taken take(unsigned tag);
    // Compares with the next publication of the port, and hands the sample on to its readers.
    // Makes NaNs canonical.
    void publish(unsigned tag, void* message, size_t bytes);
    // The first sample of the topic that the port publishes, as it was recorded; zeros if it was
    // not.
    std::vector<std::byte> first_sample(unsigned tag);

  private:
    friend class Replay;
    struct Item {
        uint8_t tag;
        bool is_used;
        uint32_t number;
        uint32_t hash;
    };
    Item* next_item(unsigned tag);

    Replay* replay_ = nullptr;
    size_t task_ = 0;
    uint64_t now_us_ = 0;
    uint64_t fired_ = 0;
    std::vector<Item> items_;
    std::vector<uint32_t> starts_;
};

// Rows of the graph that replays, generated.
struct Topic {
    const char* name;
    const FloatRun* floats;
    uint32_t float_count;
};
struct Task {
    const char* name;
    void (*run)(Job&);
};
struct Program {
    const Topic* topics;
    size_t topic_count;
    const Task* tasks;
    size_t task_count;
};
extern const Program program;

}  // namespace stator::replay
