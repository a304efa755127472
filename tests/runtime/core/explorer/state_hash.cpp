// The state of a run, so that no state is explored twice: shared words, cursors, and what each
// active job knows. Numbers of samples count by their distance to the newest one, long distances
// modulo the ring, as the code only compares differences with the depth and takes indices modulo
// the ring. Numbers in slots, and entries of the ring, that no running take can reach are left out.
#include <algorithm>
#include <bit>

#include "world.hpp"

namespace stator::explorer {

namespace {

class Hash {
  public:
    void add(uint64_t value) {
        state_ = (state_ ^ value) * 0x9E3779B97F4A7C15U;
        state_ ^= state_ >> 29;
    }
    uint64_t value() const { return state_ * 0xBF58476D1CE4E5B9U ^ state_ >> 31; }

  private:
    uint64_t state_ = 0x243F6A8885A308D3U;
};

// Distances in the order in which they are met, and the same with long gaps shortened.
class Distances {
  public:
    void add(int32_t distance) {
        all_[count_] = distance;
        ++count_;
    }
    void hash_into(Hash& hash, unsigned depth) {
        shorten(static_cast<int32_t>(depth));
        for (unsigned i = 0; i < count_; i += 2) {
            const auto low = static_cast<uint32_t>(all_[i]);
            hash.add(uint64_t{i + 1 < count_ ? static_cast<uint32_t>(all_[i + 1]) : 0U} << 32 |
                     low);
        }
    }

  private:
    // A gap beyond the depth counts modulo the ring; the newest sample is at 0.
    void shorten(int32_t depth) {
        const int32_t longest = depth + 2;
        const auto end = all_.begin() + count_;
        if (std::all_of(all_.begin(), end, [=](int32_t d) { return d <= longest; })) return;
        std::array<int32_t, kMost> sorted;
        const auto sorted_end = std::copy(all_.begin(), end, sorted.begin());
        std::sort(sorted.begin(), sorted_end);
        std::array<int32_t, kMost> moved;
        int32_t previous = 0;
        int32_t at = 0;
        for (unsigned i = 0; i < count_; ++i) {
            const int32_t gap = sorted[i] - previous;
            moved[i] = sorted[i] > 0 ? at + (gap <= longest ? gap : longest + gap % (2 * depth))
                                     : sorted[i];
            if (sorted[i] <= 0) continue;
            previous = sorted[i];
            at = moved[i];
        }
        for (auto d = all_.begin(); d != end; ++d) {
            *d = moved[static_cast<unsigned>(std::lower_bound(sorted.begin(), sorted_end, *d) -
                                             sorted.begin())];
        }
    }

    static constexpr unsigned kMost = kMostSlots + kMostUsers * 34;
    std::array<int32_t, kMost> all_;
    unsigned count_ = 0;
};

}  // namespace

bool World::is_any_in(Job::Phase phase) const {
    return std::any_of(jobs_.begin(), jobs_.begin() + job_count_,
                       [=](const Job& job) { return job.phase == phase; });
}

bool World::is_number(const void* word) const {
    return word == &state_.head || word == &turns_.head ||
           (word >= number_.data() && word < number_.data() + number_.size());
}

void World::note_load(const void* word, uint32_t value) {
    if (job_count_ == 0) return;
    Job& job = jobs_[job_count_ - 1];
    if (job.load_count == job.loads.size()) return fail("explorer: a job loads too much");
    job.loads[job.load_count] = {value, is_number(word)};
    ++job.load_count;
}

uint64_t World::state_hash() const {
    Hash hash;
    Distances numbers;
    const uint32_t head = topic_.turns != nullptr ? turns_.head.peek() : state_.head.peek();
    const auto add_number = [&](uint32_t number) {
        numbers.add(static_cast<int32_t>(head - number));
    };
    const uint32_t free = state_.free.peek();
    const uint32_t history = state_.history.peek();
    hash.add(uint64_t{free} << 32 | history);
    hash.add(is_any() && topic_.turns != nullptr
                 ? slot_of({.slot = reinterpret_cast<uintptr_t>(turns_.newest.peek())})
                 : 2);
    const bool is_taking = is_any_in(Job::Phase::kTaking);
    for (unsigned slot = 0; slot < slots_; ++slot) {
        const bool is_idle = (free & ~history & slot_mask(slot)) != 0;
        if (is_taking || !is_idle) add_number(number_[slot].peek());
    }
    if (topology_.depth > 1) {
        const bool is_whole = is_taking || is_any_in(Job::Phase::kCommitting);
        const unsigned shown =
            is_whole ? 2 * topology_.depth : static_cast<unsigned>(std::popcount(history));
        uint64_t entries = 1;
        for (unsigned i = 0; i < shown; ++i) {
            const uint32_t entry = ring_[(head - 1 - i) & (2 * topology_.depth - 1)].peek();
            entries = entries << 6 | static_cast<unsigned>(std::countl_zero(entry));
        }
        hash.add(entries);
        hash.add(is_whole);
    }
    for (unsigned i = 0; i < topology_.users.size(); ++i) {
        if (topology_.users[i].role.reads_queue()) add_number(cursor_[i]);
    }
    for (unsigned i = 0; i < job_count_; ++i) {
        const Job& job = jobs_[i];
        hash.add(uint64_t{job.published} << 48 | uint64_t{job.user} << 40 |
                 uint64_t{static_cast<uint8_t>(job.phase)} << 32 | uint64_t{job.accesses} << 16 |
                 job.load_count);
        hash.add(job.has_pin ? uint64_t{slot_of(job.pin)} << 32 | job.pin.saved_free : ~0ULL);
        hash.add(job.has_loan ? uint64_t{job.loaned.slot} << 32 | job.loaned.word : ~0ULL);
        if (job.phase == Job::Phase::kTaking) {
            // What the checks of this take will ask for.
            const unsigned user = job.user;
            const bool is_queue = topology_.users[user].role.reads_queue();
            hash.add(is_queue ? job.newest_at_start != cursor_[user] : job.any_at_start);
            if (!is_queue) add_number(job.newest_at_start);
        }
        for (unsigned k = 0; k < job.load_count; ++k) {
            const auto& [value, is_sequence] = job.loads[k];
            if (is_sequence) add_number(value);
            if (!is_sequence) hash.add(value);
        }
    }
    hash.add(ceiling_);
    numbers.hash_into(hash, topology_.depth);
    return hash.value();
}

}  // namespace stator::explorer
