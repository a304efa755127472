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
#include <string_view>

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
class RecordStream {
  public:
    // `size`: a power of two.
    constexpr RecordStream(uint8_t* bytes, uint32_t size) : bytes_(bytes), mask_(size - 1) {}
    RecordStream(const RecordStream&) = delete;
    RecordStream& operator=(const RecordStream&) = delete;

    // --- for the wrapper of a task: one record, from `begin` to `end` ---

    // Where a part of a record is written, in registers until it is complete. The caller has asked
    // for room for the most that it can be.
    class Part {
      public:
        [[gnu::always_inline]] explicit Part(RecordStream& stream)
            : stream_(stream),
              bytes_(stream.bytes_),
              mask_(stream.mask_),
              position_(stream.position_) {}
        Part(const Part&) = delete;
        Part& operator=(const Part&) = delete;
        [[gnu::always_inline]] ~Part() { stream_.position_ = position_; }

        [[gnu::always_inline]] void byte(uint8_t value) { bytes_[position_++ & mask_] = value; }
        // Seven bits a byte, the lowest first; the top bit says that more follow.
        [[gnu::always_inline]] void number(uint32_t value) {
            for (; value > 0x7F; value >>= 7) byte(static_cast<uint8_t>(value | 0x80U));
            byte(static_cast<uint8_t>(value));
        }
        [[gnu::always_inline]] void number64(uint64_t value) {
            for (; value > UINT32_MAX; value >>= 7) byte(static_cast<uint8_t>(value | 0x80U));
            number(static_cast<uint32_t>(value));
        }
        // A port took a sample; `further`: its number less that of the sample taken before.
        [[gnu::always_inline]] void take(uint8_t tag, uint32_t further) {
            byte(tag);
            number(further);
        }
        void bytes(const void* from, uint32_t count) {
            const uint32_t begin = position_ & mask_;
            const uint32_t room = mask_ + 1 - begin;
            position_ += count;
            if (count <= room) {
                std::memcpy(bytes_ + begin, from, count);
                return;
            }
            std::memcpy(bytes_ + begin, from, room);
            std::memcpy(bytes_, static_cast<const uint8_t*>(from) + room, count - room);
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
        uint8_t* bytes_;
        uint32_t mask_;
        uint32_t position_;
    };

    // The most bytes of a part.
    static constexpr uint32_t kNumberBytes = 5;
    static constexpr uint32_t kTakeBytes = 1 + kNumberBytes;
    static constexpr uint32_t kConcludeBytes = 1 + 2 * 10;

    // A record that is begun and not ended leaves no trace. It may stand before `step`, so it asks
    // nothing: `has_room` has left room for it.
    [[gnu::always_inline]] void begin(uint32_t task) {
        position_ = written_.load(std::memory_order_relaxed);
        Part(*this).number(task);
    }
    // False, and the record will be lost, if it may need more than there is; so are all after it.
    // Keeps room for the next record's beginning.
    [[gnu::always_inline]] bool has_room(uint32_t count) {
        const uint32_t used = position_ - taken_.load(kSeen);
        std::atomic_signal_fence(std::memory_order_seq_cst);
        is_full_ = is_full_ || mask_ + 1 - used < count + kNumberBytes;
        return !is_full_;
    }
    [[gnu::noinline]] void take(uint8_t tag, uint32_t further) {
        if (has_room(kTakeBytes)) Part(*this).take(tag, further);
    }
    [[gnu::noinline]] void number(uint32_t value) {
        if (has_room(kNumberBytes)) Part(*this).number(value);
    }
    [[gnu::always_inline]] void end() {
        if (!is_full_) {
            std::atomic_signal_fence(std::memory_order_seq_cst);
            written_.store(position_, kDone);
            return;
        }
        const uint32_t lost = lost_.load(std::memory_order_relaxed);
        lost_.store(lost + 1, kDone);
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
        preemptions_ += outer != nullptr ? 1U : 0U;
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
    // The stream of the innermost job that is in its node now, over all levels of the machine.
    // Where levels are threads, none interrupts another one inside the program.
#ifdef __linux__
    static inline thread_local std::atomic<RecordStream*> inside{nullptr};
#else
    static inline std::atomic<RecordStream*> inside{nullptr};
#endif

    uint8_t* bytes_;
    uint32_t mask_;                     // size less 1
    std::atomic<uint32_t> written_{0};  // both count bytes modulo 2^32
    std::atomic<uint32_t> taken_{0};
    std::atomic<uint32_t> lost_{0};
    uint32_t position_ = 0;  // of the record that is being written
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
    const FloatRun* floats;
    uint16_t float_count;
};

// One for each level, and one for what is published before anything runs.
inline constexpr unsigned kMaxStreams = 16;

// The generated recording of a graph as the logger sees it.
struct RecordingTable {
    RecordStream* const* streams;  // by level; 0: what was published before anything ran
    uint32_t stream_count;
    const std::string_view* definitions;  // lines that say what tasks and topics the numbers mean
    uint32_t definition_count;
    uint32_t blocks_at_once;  // at most, of one activation of the logger
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
