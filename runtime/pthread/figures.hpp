// What a task has counted, for a thread that looks at any time.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "stator/task.hpp"

namespace stator {

// The counters of one task as they were between two activations: never of two. One writer, the
// task's level, which never waits. On a cache line of its own, as each activation writes it.
class alignas(64) Figures {
  public:
    // Context: the task's level, after an activation.
    void keep(const TaskCounters& counters) {
        const auto words = std::bit_cast<Words>(counters);
        const uint32_t version = version_.load(std::memory_order_relaxed);
        version_.store(version + 1, std::memory_order_relaxed);
        // Release: who sees a new word sees the odd version as well.
        for (size_t i = 0; i < words.size(); ++i) {
            words_[i].store(words[i], std::memory_order_release);
        }
        version_.store(version + 2, std::memory_order_release);
    }
    // False: the writer came in between; then `counters` stays as it is.
    [[nodiscard]] bool read(TaskCounters& counters) const {
        const uint32_t version = version_.load(std::memory_order_acquire);
        Words words{};
        for (size_t i = 0; i < words.size(); ++i) {
            words[i] = words_[i].load(std::memory_order_acquire);
        }
        if (version % 2 != 0 || version_.load(std::memory_order_relaxed) != version) return false;
        counters = std::bit_cast<TaskCounters>(words);
        return true;
    }

  private:
    using Words = std::array<uint32_t, sizeof(TaskCounters) / sizeof(uint32_t)>;

    std::atomic<uint32_t> version_{0};  // odd while the words change
    std::array<std::atomic<uint32_t>, std::tuple_size_v<Words>> words_{};
};

}  // namespace stator
