// The newest value of something that one context writes and others read: a simulated part that has
// no line, so that nothing keeps its reader from being interrupted by the next value.
//
// Two copies: a reader takes the one that is complete, while the writer fills the other. A reader
// during whose copying a value was completed copies again; so it never waits for the writer, and
// may be more urgent than it. Any context.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace stator {

template <class Value>
class Newest {
    static_assert(std::is_trivially_copyable_v<Value>);

  public:
    struct Read {
        Value value{};
        uint32_t count = 0;  // of the values until then, to tell a new one; wraps
    };

    // One writer.
    void put(const Value& value) {
        const uint32_t count = count_.load(std::memory_order_relaxed) + 1;
        std::array<uint32_t, kWords> words{};
        std::memcpy(words.data(), &value, sizeof value);
        // Whoever sees one of these words sees the count before, too, and copies again.
        for (size_t i = 0; i < kWords; ++i) {
            copies_[count % 2][i].store(words[i], std::memory_order_release);
        }
        count_.store(count, std::memory_order_release);
    }

    // Before the first `put`: Value{}, and 0.
    Read get() const {
        while (true) {
            const uint32_t count = count_.load(std::memory_order_acquire);
            if (count == 0) return {};
            std::array<uint32_t, kWords> words;
            for (size_t i = 0; i < kWords; ++i) {
                words[i] = copies_[count % 2][i].load(std::memory_order_acquire);
            }
            if (count_.load(std::memory_order_relaxed) != count) continue;
            Read read{.count = count};
            std::memcpy(static_cast<void*>(&read.value), words.data(), sizeof read.value);
            return read;
        }
    }

  private:
    static constexpr size_t kWords = (sizeof(Value) + 3) / 4;

    std::array<std::array<std::atomic<uint32_t>, kWords>, 2> copies_{};
    std::atomic<uint32_t> count_ = 0;
};

}  // namespace stator
