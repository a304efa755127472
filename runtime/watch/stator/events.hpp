// What happened that a flight log should tell: few, and written by one context only.
#pragma once

#include <array>
#include <cstdint>

#include "stator/topic.hpp"

namespace stator {

// `what` and `name` are constant texts, told one behind the other.
struct LogEvent {
    uint64_t time_us = 0;
    const char* what = "";
    const char* name = "";
};

// The newest events. One writer, which its readers preempt or run beside; those that lag behind by
// more than the list holds lose the oldest.
class LogEvents {
  public:
    // Context: the executor's monitor.
    void add(const LogEvent& event) {
        const uint32_t count = count_.load();
        events_[count % kMax] = event;
        count_.store(count + 1);
    }
    // Moves `cursor` on to the next event; false if there is none.
    bool next(uint32_t& cursor, LogEvent& event) const {
        const uint32_t count = count_.load();
        if (cursor == count) return false;
        if (count - cursor >= kMax) cursor = count - kMax + 1;
        event = events_[cursor % kMax];
        cursor += 1;
        return true;
    }

  private:
    static constexpr uint32_t kMax = 16;
    std::array<LogEvent, kMax> events_{};
    Shared<uint32_t> count_;
};
extern LogEvents event_log;  // of the executor

}  // namespace stator
