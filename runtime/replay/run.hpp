// Runs a recording again: every activation of the graph's nodes with exactly what it had, whoever
// interrupted it; drivers and logger do not run. What is published is compared with the recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "recording.hpp"
#include "stator/replay.hpp"

namespace stator::replay {

struct Difference {
    enum class Kind { kValue, kMissing, kExtra };
    Kind kind;
    size_t topic;
    uint32_t number;
    uint64_t now_us;
    uint32_t recorded_hash;
    uint32_t hash;
    std::vector<uint8_t> recorded;  // the sample, where the recording has it
    std::vector<uint8_t> replayed;
};

struct TopicResult {
    uint64_t compared = 0;
    uint64_t different = 0;
};

// Of the activation that began last, for the report of a crash.
inline uint64_t newest_activation_us = 0;

class Replay {
  public:
    explicit Replay(const Recording& recording);

    // False if a stream makes no sense.
    [[nodiscard]] bool scan();
    void run();

    const std::vector<TopicResult>& results() const { return results_; }
    const std::optional<Difference>& first() const { return first_; }
    uint64_t activations() const { return activations_; }
    // Up to when everything was replayed: to the first activation that could not be, or the first
    // gap.
    uint64_t until_us() const;
    // The newest activation in the recording.
    uint64_t recorded_until_us() const;

  private:
    friend class Job;
    enum class State : uint8_t { kRecorded, kMade, kMissing, kBeyond };

    // Samples by number, from 1; sized by `scan`, so that they stay where they are.
    struct Store {
        std::vector<uint8_t> samples;
        std::vector<State> states;
        std::vector<uint32_t> producers;  // tasks
        const Topic* row = nullptr;       // of the graph that replays
    };
    struct Activation {
        uint64_t now_us;
        size_t at;  // in the stream
    };
    struct TaskState {
        void (*run)(Job&) = nullptr;  // null: not to be replayed
        std::vector<Activation> activations;
        size_t next = 0;
        std::vector<uint32_t> numbers;  // newest, by port
        uint64_t now_us = 0;
        bool is_over = false;  // something that it needs lies beyond the recording's end
    };
    struct Level {
        std::vector<uint32_t> tasks;  // in the order of their activations
        size_t next = 0;
        std::vector<size_t> seen;  // by task: activations passed in `tasks`
    };

    bool scan_level(unsigned level);
    bool read(Reader& reader, Job& job, bool is_scan);
    void keep(const Job& job, const Job::Item& item, const uint8_t* whole);
    uint64_t end_us(size_t level) const;
    Level* earliest();
    void run_head(Level& level);
    void run_next(size_t index);
    bool needs_more_than_there_is(const Job& job) const;
    void conclude(Job& job, bool is_run);
    const void* sample(size_t topic, uint32_t number);
    void compare(Job& job, Job::Item& item, const Port& port, const void* message);
    void differ(Difference difference);
    uint8_t* slot(size_t topic, uint32_t number);

    const Recording& recording_;
    std::vector<Store> stores_;
    std::vector<TaskState> tasks_;
    std::array<Level, kStreams> levels_;
    std::vector<TopicResult> results_;
    std::optional<Difference> first_;
    uint64_t activations_ = 0;
    uint64_t skipped_us_ = UINT64_MAX;  // the first activation that was not run
};

}  // namespace stator::replay
