// What every executor answers on its link in the same bytes: docs/link.md lists requests and
// answers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "stator/link.hpp"
#include "stator/parameter_box.hpp"
#include "stator/task.hpp"
#include "stator/watch.hpp"

namespace stator {

enum class Request : uint8_t { kInfo = 1, kTasks = 2, kSample = 3, kFault = 4, kParameter = 5 };
inline constexpr uint8_t kLinkVersion = 1;
inline constexpr unsigned kMaxTasksTold = 20;      // in an answer
inline constexpr uint16_t kMaxSampleBytes = 1000;  // told of a sample

// Puts values one behind the other, little-endian, without padding.
class Writer {
  public:
    explicit Writer(uint8_t* at) : begin_(at), at_(at) {}
    template <class Value>
    void put(Value value) {
        put(&value, sizeof value);
    }
    void put(const void* bytes, size_t count) {
        std::memcpy(at_, bytes, count);
        at_ += count;
    }
    void text(const char* text) {
        const auto count = static_cast<uint8_t>(std::min<size_t>(std::strlen(text), 64));
        put(count);
        put(text, count);
    }
    // Room that another one fills.
    uint8_t* at() const { return at_; }
    void skip(size_t count) { at_ += count; }
    size_t count() const { return static_cast<size_t>(at_ - begin_); }

  private:
    uint8_t* begin_;
    uint8_t* at_;
};

// A request and its argument; begins the answer.
struct Asked {
    Request kind;
    unsigned argument;
};
inline bool begin_answer(const uint8_t* request, size_t count, Writer& out, Asked& asked) {
    if (count < 4) return false;
    asked = {static_cast<Request>(request[0]),
             static_cast<unsigned>(request[2] | (request[3] << 8))};
    out.put(request[0]);
    out.put(request[1]);  // what the asker calls this request
    return true;
}

// `cause`: of the last run's end, 0 if it has left no record.
template <class Program>
void put_info(Writer& out, const Program& graph, const TickSource& ticks, uint64_t now_us,
              bool is_safe_mode = false, uint8_t cause = 0) {
#ifdef STATOR_COUNTERS
    const uint32_t hz = ticks.hz;
#else
    const uint32_t hz = 0;  // nothing is measured
#endif
    out.put(kLinkVersion);
    out.put(static_cast<uint8_t>(is_safe_mode));
    out.put(cause);
    out.put(ticks.unit);
    out.put(ticks.per_unit);
    out.put(hz);
    out.put(now_us);
    out.put(static_cast<uint16_t>(graph.task_count));
    out.put(static_cast<uint16_t>(graph.topic_count));
    out.put(graph.graph_hash, 16);
    out.text(graph.graph);
    out.text(graph.board);
}

static_assert(sizeof(TaskCounters) == 6 * sizeof(uint32_t));  // as the answer tells them

inline uint32_t missed_life_signs_of(unsigned task, const Watched* rows, unsigned count) {
    for (unsigned i = 0; i < count; ++i) {
        if (rows[i].task == task) return rows[i].state->missed;
    }
    return 0;
}

// What a task has counted, as it was between two activations. For a reader below all tasks of one
// core: a task that comes in between has ended when the reader goes on, and is seen by its count.
// `load` reads one counter. After so many tries, the last copy counts, which may be of two
// activations.
template <class Load>
TaskCounters figures_below_tasks(const TaskCounters& counters, Load load) {
    constexpr unsigned kMaxTries = 8;
    TaskCounters copy;
    for (unsigned i = 0; i < kMaxTries; ++i) {
        copy = {.activations = load(counters.activations),
                .lost_samples = load(counters.lost_samples),
                .ticks = load(counters.ticks),
                .last_ticks = load(counters.last_ticks),
                .most_ticks = load(counters.most_ticks),
                .latest_us = load(counters.latest_us)};
        if (load(counters.activations) == copy.activations) break;
    }
    return copy;
}

// `figures_of`: from a task's index to its counters between two activations.
template <class Program, class FiguresOf>
void put_tasks(Writer& out, const Program& graph, uint64_t now_us, unsigned first,
               FiguresOf figures_of) {
    out.put(now_us);
    out.put(static_cast<uint16_t>(first));
    for (unsigned i = first; i < std::min(first + kMaxTasksTold, graph.task_count); ++i) {
        out.put(figures_of(i));
        out.put(missed_life_signs_of(i, graph.watched, graph.watched_count));
    }
}

// The request holds behind its index: u16 tag, u8 action, u8 type, u32 value.
inline bool put_parameter(Writer& out, ParameterBox* box, const uint8_t* request, size_t count) {
    constexpr size_t kBytes = 12;
    if (count != kBytes) return false;
    ParameterBox::Ask ask{};
    std::memcpy(&ask.index, request + 2, sizeof ask.index);
    std::memcpy(&ask.tag, request + 4, sizeof ask.tag);
    ask.action = request[6];
    ask.type = request[7];
    std::memcpy(&ask.value, request + 8, sizeof ask.value);
    ParameterBox::Answer answer{};
    const auto progress =
        box == nullptr ? ParameterBox::Progress::kUnserved : box->ask(ask, answer);
    out.put(static_cast<uint8_t>(progress));
    out.put(answer.result);
    out.put(answer.value);
    return true;
}

}  // namespace stator
