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

#ifdef __linux__
inline constexpr auto kSeen = std::memory_order_acquire;
inline constexpr auto kDone = std::memory_order_release;
#else
// On one core only the compiler could change the order, and the fences below forbid it.
inline constexpr auto kSeen = std::memory_order_relaxed;
inline constexpr auto kDone = std::memory_order_relaxed;
#endif

// What a level records. One producer: the job of this level that runs. One consumer: the logger.
//
// A ring of bytes. A part of a record is written side by side, even where it runs over the ring's
// end: behind it lies some memory to spare, and what got there moves to the beginning before
// anybody sees it. So one comparison says whether the next part may simply be written.
class RecordStream {
  public:
    // The most bytes of a part.
    static constexpr uint32_t kNumberBytes = 5;
    static constexpr uint32_t kTakeBytes = 1 + kNumberBytes;
    // What a wrapper writes behind `step`: of `inputs` what they noted, and `numbers` besides.
    static constexpr uint32_t conclude_bytes(uint32_t inputs, uint32_t numbers) {
        return inputs * kTakeBytes + 1 + 2 * 10 + numbers * kNumberBytes;
    }
    // Samples of up to so many bytes are part of a part; longer ones are appended.
    static constexpr uint32_t kShortBytes = 64;
    // To spare behind the ring of a level: its longest part. The most of each of its tasks.
    static constexpr uint32_t spare_bytes(uint32_t inputs, uint32_t numbers) {
        const uint32_t conclude = conclude_bytes(inputs, numbers);
        const uint32_t sample = kTakeBytes + kShortBytes;
        return conclude < sample ? sample : conclude;
    }

    // `size`: a power of two; there are as many bytes, and those to spare.
    constexpr RecordStream(uint8_t* bytes, uint32_t size)
        : to_(bytes), limit_(bytes), begin_(bytes), bytes_(bytes), mask_(size - 1) {}
    RecordStream(const RecordStream&) = delete;
    RecordStream& operator=(const RecordStream&) = delete;

    // --- for the wrapper of a task: one record, from `begin` to `end` ---

    // Writes a part of a record. The caller has asked for room for the most that it can be.
    class Part {
      public:
        [[gnu::always_inline]] explicit Part(RecordStream& stream)
            : stream_(stream), to_(stream.to_) {}
        Part(const Part&) = delete;
        Part& operator=(const Part&) = delete;
        [[gnu::always_inline]] ~Part() { stream_.to_ = to_; }

        [[gnu::always_inline]] void byte(uint8_t value) { *to_++ = value; }
        // Seven bits a byte, the lowest first; the top bit says that more follow.
        [[gnu::always_inline]] void number(uint32_t value) {
            if (value <= 0x7F) [[likely]] {
                byte(static_cast<uint8_t>(value));
            } else {
                to_ = long_number(to_, value);
            }
        }
        [[gnu::always_inline]] void number64(uint64_t value) {
            if (value > 0x3FFF) [[unlikely]] {
                to_ = long_number(to_, value);
                return;
            }
            const auto low = static_cast<uint32_t>(value);
            if (low > 0x7F) byte(static_cast<uint8_t>(low | 0x80U));
            byte(static_cast<uint8_t>(low > 0x7F ? low >> 7 : low));
        }
        [[gnu::always_inline]] void hash(uint32_t value) { bytes<sizeof value>(&value); }
        template <uint32_t kCount>
        [[gnu::always_inline]] void bytes(const void* from) {
            std::memcpy(to_, from, kCount);
            to_ += kCount;
        }
        // A port took a sample; `further`: its number less that of the sample taken before.
        [[gnu::always_inline]] void take(uint8_t tag, uint32_t further) {
            byte(tag);
            number(further);
        }
        // Behind what was taken and published: how the activation came about. `previous_us`: of
        // the same task, brought up to date.
        [[gnu::always_inline]] void conclude(uint64_t fired, uint64_t now_us,
                                             uint64_t& previous_us) {
            const uint64_t later_us = now_us - previous_us;
            previous_us = now_us;
            byte(0);
            number64(fired);
            number64(later_us);
        }

      private:
        RecordStream& stream_;
        uint8_t* to_;
    };

    // A record that is begun, and has no part yet, leaves no trace. It may stand before `step`, so
    // it asks nothing: `has_room` has left room for it.
    [[gnu::always_inline]] void begin(uint32_t task) {
        to_ = begin_;
        Part(*this).number(task);
    }
    // False, and the record will be lost, if it may need more than there is; so are all after it.
    // Keeps room for the next record's beginning.
    [[gnu::always_inline]] bool has_room(uint32_t count) {
        return limit_ - to_ >= static_cast<ptrdiff_t>(count) || makes_room(count);
    }
    [[gnu::noinline]] void take(uint8_t tag, uint32_t further) {
        if (has_room(kTakeBytes)) Part(*this).take(tag, further);
    }
    [[gnu::noinline]] void number(uint32_t value) {
        if (has_room(kNumberBytes)) Part(*this).number(value);
    }
    // A part of any length, without its own memory to spare.
    [[gnu::noinline]] void append(const void* from, uint32_t count) {
        if (!has_room(count)) return;
        const auto room = static_cast<uint32_t>(ring_end() - to_);
        if (count < room) {
            std::memcpy(to_, from, count);
            to_ += count;
            return;
        }
        std::memcpy(to_, from, room);
        to_ += room;
        go_round();
        std::memcpy(to_, static_cast<const uint8_t*>(from) + room, count - room);
        to_ += count - room;
        limit_ = to_;
    }
    [[gnu::always_inline]] void end() {
        if (to_ > limit_) [[unlikely]] {
            if (!ends_slowly()) return;
        }
        begin_ = to_;
        const uint32_t written = position();
        std::atomic_signal_fence(std::memory_order_seq_cst);
        written_.store(written, kDone);
    }

    // Around `step`: who is in its node, and how often another job came in between. `leave` gets
    // what `enter` returned.
    RecordStream* enter() {
        RecordStream* const outer = inside.load(std::memory_order_relaxed);
        inside.store(this, std::memory_order_relaxed);
        return outer;
    }
    void leave(RecordStream* outer) {
        inside.store(outer, std::memory_order_relaxed);
        if (outer != nullptr) [[unlikely]] {
            ++preemptions_;
        }
    }

    // --- for the logger ---

    uint32_t available() const {
        const uint32_t written = written_.load(kSeen);
        std::atomic_signal_fence(std::memory_order_seq_cst);
        return written - taken_.load(std::memory_order_relaxed);
    }
    // The next bytes, as many of at most `count` as lie side by side.
    std::span<const uint8_t> peek(uint32_t count) const {
        const uint32_t begin = taken_.load(std::memory_order_relaxed) & mask_;
        const uint32_t side_by_side = mask_ + 1 - begin;
        return {bytes_ + begin, count < side_by_side ? count : side_by_side};
    }
    void take(uint32_t count) {
        std::atomic_signal_fence(std::memory_order_seq_cst);
        taken_.store(taken_.load(std::memory_order_relaxed) + count, kDone);
    }
    // Activations that found no room.
    uint32_t lost() const { return lost_.load(kSeen); }
    uint32_t preemptions() const { return preemptions_; }

  private:
    template <class Value>
    [[gnu::noinline]] static uint8_t* long_number(uint8_t* to, Value value) {
        for (; value > 0x7F; value >>= 7) *to++ = static_cast<uint8_t>(value | 0x80U);
        *to++ = static_cast<uint8_t>(value);
        return to;
    }

    uint8_t* ring_end() const { return bytes_ + mask_ + 1; }
    uint32_t position() const { return base_ + static_cast<uint32_t>(to_ - bytes_); }

    // From behind the ring's end to its beginning.
    void go_round() {
        if (to_ < ring_end()) return;
        const auto over = static_cast<size_t>(to_ - ring_end());
        std::memcpy(bytes_, ring_end(), over);
        to_ = bytes_ + over;
        base_ += mask_ + 1;
    }
    [[gnu::noinline, gnu::cold]] bool makes_room(uint32_t count) {
        if (is_full_) return false;
        go_round();
        const uint32_t used = position() - taken_.load(kSeen);
        std::atomic_signal_fence(std::memory_order_seq_cst);
        const uint32_t room = mask_ + 1 - used;
        if (room < count + kNumberBytes) {
            // From now on a record's beginning goes behind the ring, and all else asks here.
            is_full_ = true;
            to_ = begin_ = ring_end();
            limit_ = bytes_;
            return false;
        }
        const auto side_by_side = static_cast<uint32_t>(ring_end() - to_);
        limit_ = to_ + (room - kNumberBytes < side_by_side ? room - kNumberBytes : side_by_side);
        return true;
    }
    // False if the record is lost.
    [[gnu::noinline, gnu::cold]] bool ends_slowly() {
        if (is_full_) {
            lost_.store(lost_.load(std::memory_order_relaxed) + 1, kDone);
            return false;
        }
        go_round();
        limit_ = to_;
        return true;
    }

    // The stream of the innermost job that is in its node now, over all levels of the machine.
    // Where levels are threads, none interrupts another one inside the program.
#ifdef __linux__
    static inline thread_local std::atomic<RecordStream*> inside{nullptr};
#else
    static inline std::atomic<RecordStream*> inside{nullptr};
#endif

    uint8_t* to_;     // the next byte of the record that is being written
    uint8_t* limit_;  // up to here all is free and lies side by side; below `to_` where it is not
    uint8_t* begin_;  // of the record
    uint8_t* bytes_;
    uint32_t mask_;                     // size less 1
    uint32_t base_ = 0;                 // position of the first byte: how often the ring went round
    std::atomic<uint32_t> written_{0};  // positions: both count bytes modulo 2^32
    std::atomic<uint32_t> taken_{0};
    std::atomic<uint32_t> lost_{0};
    uint32_t preemptions_ = 0;
    bool is_full_ = false;
};

// How the publications of an output are recorded.
struct RecordedOutput {
    enum class How : uint8_t {
        kHash,
        kWhole,  // the sample itself, as nobody can compute it again
        kStamp,  // only that there was one: of the logger, as its blocks hold the recording
    };
    uint8_t tag;
    How how;
    // Of one whose type its port does not know.
    const FloatRun* floats = nullptr;
    uint16_t float_count = 0;
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
