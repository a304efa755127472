// Keeps what every task read and published, so that a flight can be replayed: docs/recording.md has
// the format. Only builds with STATOR_RECORDING have streams.
//
// Jobs of one level run one after the other, so each level writes a stream of its own, and the
// logger takes the bytes into the log. Nothing locks, masks or waits. A stream without room loses
// whole activations, which is counted; from there on it stays silent, as a replay ends there
// anyway.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "stator/canonical.hpp"

namespace stator {

// What a level records. One producer: the job of this level that runs. One consumer: the logger.
class RecordStream {
  public:
    // `size`: a power of two.
    constexpr RecordStream(uint8_t* bytes, uint32_t size) : bytes_(bytes), size_(size) {}
    RecordStream(const RecordStream&) = delete;
    RecordStream& operator=(const RecordStream&) = delete;

    // --- for the wrapper of a task: one record, from `begin` to `end` ---

    // A record that is begun and not ended leaves no trace. Stands before `step`, so it asks
    // nothing: `has_room` has left room for it.
    void begin(uint32_t task) {
        position_ = written_.load(std::memory_order_relaxed);
        put_number(task);
    }
    // Seven bits a byte, the lowest first; the top bit says that more follow.
    [[gnu::noinline]] void number(uint64_t value) {
        if (has_room(kMaxNumberBytes)) put_number(value);
    }
    void data(const void* from, uint32_t count) {
        if (!has_room(count)) return;
        const uint32_t begin = position_ & (size_ - 1);
        const uint32_t first = count < size_ - begin ? count : size_ - begin;
        std::memcpy(bytes_ + begin, from, first);
        std::memcpy(bytes_, static_cast<const uint8_t*>(from) + first, count - first);
        position_ += count;
    }
    // Behind what was taken and published: how the activation came about. `previous_us`: of the
    // same task, brought up to date.
    void conclude(uint64_t fired, uint64_t now_us, uint64_t& previous_us) {
        number(0);
        number(fired);
        number(now_us - previous_us);
        previous_us = now_us;
    }
    void end() {
        if (!is_full_) {
            written_.store(position_, std::memory_order_release);
            return;
        }
        const uint32_t lost = lost_.load(std::memory_order_relaxed);
        lost_.store(lost + 1, std::memory_order_release);
    }

    // Around `step`: who is in its node, and how often another job came in between.
    void enter() {
        outer_ = inside.load(std::memory_order_relaxed);
        inside.store(this, std::memory_order_relaxed);
    }
    void leave() {
        preemptions_ += outer_ != nullptr ? 1U : 0U;
        inside.store(outer_, std::memory_order_relaxed);
    }

    // --- for the logger ---

    uint32_t available() const {
        return written_.load(std::memory_order_acquire) - taken_.load(std::memory_order_relaxed);
    }
    // The next bytes, as many of at most `count` as lie side by side.
    std::span<const uint8_t> peek(uint32_t count) const {
        const uint32_t begin = taken_.load(std::memory_order_relaxed) & (size_ - 1);
        return {bytes_ + begin, count < size_ - begin ? count : size_ - begin};
    }
    void take(uint32_t count) {
        taken_.store(taken_.load(std::memory_order_relaxed) + count, std::memory_order_release);
    }
    // Activations that found no room.
    uint32_t lost() const { return lost_.load(std::memory_order_acquire); }
    uint32_t preemptions() const { return preemptions_; }

  private:
    static constexpr uint32_t kMaxNumberBytes = 10;
    static constexpr uint32_t kMaxTaskBytes = 5;  // of the number that begins a record

    // Asks for a little more than may be needed, and keeps room for the next record's beginning.
    // A record that it refuses is lost whole, and so are all after it.
    bool has_room(uint32_t count) {
        const uint32_t used = position_ - taken_.load(std::memory_order_acquire);
        is_full_ = is_full_ || size_ - used < count + kMaxTaskBytes;
        return !is_full_;
    }
    void put_number(uint64_t value) {
        for (; value > 0x7F; value >>= 7) put(static_cast<uint8_t>(value | 0x80U));
        put(static_cast<uint8_t>(value));
    }
    void put(uint8_t byte) { bytes_[position_++ & (size_ - 1)] = byte; }

    // The stream of the innermost job that is in its node now, over all levels of the machine.
    // Where levels are threads, none interrupts another one inside the program.
#ifdef __linux__
    static inline thread_local std::atomic<RecordStream*> inside{nullptr};
#else
    static inline std::atomic<RecordStream*> inside{nullptr};
#endif

    uint8_t* bytes_;
    uint32_t size_;
    std::atomic<uint32_t> written_{0};  // both count bytes modulo 2^32
    std::atomic<uint32_t> taken_{0};
    std::atomic<uint32_t> lost_{0};
    uint32_t position_ = 0;          // of the record that is being written
    RecordStream* outer_ = nullptr;  // of the job that is in its node
    uint32_t preemptions_ = 0;
    bool is_full_ = false;
};

// How the publications of an output are recorded.
struct RecordedOutput {
    enum class How : uint8_t {
        kCrc,
        kWhole,  // the sample itself, as nobody can compute it again
        kStamp,  // only that there was one: of the logger, as its blocks hold the recording
    };
    uint8_t tag;
    How how;
    const FloatRun* floats;
    uint16_t float_count;
};

// One for each level, and one for what is published before anything runs.
inline constexpr unsigned kMaxStreams = 16;

// The generated recording of a graph as the logger sees it.
struct RecordingTable {
    RecordStream* const* streams;  // by level; 0: what was published before anything ran
    uint32_t stream_count;
    const char* const* definitions;  // lines that say what tasks and topics the numbers mean
    uint32_t definition_count;
};

struct RecordingCounts {
    uint64_t preemptions = 0;  // how often a task was interrupted inside its node by another
    uint64_t lost = 0;         // activations that are not in the recording
};

#ifdef STATOR_RECORDING
extern const RecordingTable recording_table;  // generated

inline RecordingCounts recording_counts() {
    RecordingCounts counts;
    for (uint32_t i = 0; i < recording_table.stream_count; ++i) {
        counts.preemptions += recording_table.streams[i]->preemptions();
        counts.lost += recording_table.streams[i]->lost();
    }
    return counts;
}

#else

inline RecordingCounts recording_counts() {
    return {};
}

#endif

}  // namespace stator
