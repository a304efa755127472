// The newest value of something that the interrupt of the plant's step writes and a task reads.
//
// Two copies: the reader takes the one that is complete, the writer fills the other. It holds while
// a reader is not preempted by two writes.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace stator::board {

template <class Value>
class Newest {
  public:
    void put(const Value& value) {
        const uint32_t next = count_.load(std::memory_order_relaxed) + 1;
        values_[next % 2] = value;
        count_.store(next, std::memory_order_release);
    }
    // Before the first `put`, Value{}.
    Value get() const { return values_[count() % 2]; }
    uint32_t count() const { return count_.load(std::memory_order_acquire); }

  private:
    std::array<Value, 2> values_{};
    std::atomic<uint32_t> count_ = 0;
};

}  // namespace stator::board
