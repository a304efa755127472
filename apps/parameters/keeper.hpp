// Keeps the parameters that differ from the graph's as records, and takes them back after a start.
#pragma once

#include <array>
#include <cstdint>

#include "parameters_ports.hpp"

namespace stator::apps::parameters {

// One bit for each of the parameters; more than that the compiler refuses.
class Marks {
  public:
    static constexpr unsigned kMost = 512;

    bool has(unsigned i) const { return i < kMost && (words_[i / 32] >> i % 32 & 1U) != 0; }
    // Says whether that is a change.
    bool set(unsigned i, bool value = true) {
        if (i >= kMost || has(i) == value) return false;
        words_[i / 32] ^= 1U << i % 32;
        count_ = static_cast<uint16_t>(count_ + (value ? 1 : -1));
        return true;
    }
    uint16_t count() const { return count_; }
    // The next one that is set, from here on and then from the first; `kMost`: none is.
    unsigned next(unsigned from) const;

  private:
    std::array<uint32_t, kMost / 32> words_{};
    uint16_t count_ = 0;
};

// A record holds a value and the definition of its parameter (type and unit). One of another
// definition, or whose value is not in the range, stays in the memory and does not count; a new
// value of that parameter replaces it. A record under a former name counts if there is none under
// the new one, and is replaced by that.
//
// If the last starts ended soon, one of the values may be why. Then none counts in this life.
class Keeper {
  public:
    // Records that have been loaded, and results of records to keep. One of each in an activation.
    void take(ParametersPorts& ports);
    // A request has changed the value of this row.
    void change(const ParametersPorts& ports, unsigned row);
    // Publishes the next record to keep, and what has changed in the report.
    void work(ParametersPorts& ports);

  private:
    static constexpr unsigned kMaxShortLives = 2;
    static constexpr unsigned kMaxTries = 5;
    static constexpr uint64_t kResultTime_us = 500'000;  // the memory needs a hundredth of it
    static constexpr unsigned kNone = Marks::kMost;

    // A record that was published and has no result yet: of a row, or of a former name of it.
    struct Pending {
        unsigned row = kNone;
        uint32_t key = 0;
        uint64_t until_us = 0;
        bool is_removal = false;
        bool is_former = false;
    };

    void take_record(ParametersPorts& ports, const StoredRecord& record);
    void apply(ParametersPorts& ports, unsigned row, const StoredRecord& record, bool is_former);
    void leave(unsigned row, uint16_t& count);
    void conclude(bool is_kept);
    void publish_next(ParametersPorts& ports);
    void publish(ParametersPorts& ports, const StoredRecord& record);
    void report(ParametersPorts& ports);

    Marks stored_;   // have a record
    Marks asked_;    // were changed in this life: then a record that is loaded later does not count
    Marks waiting_;  // have a value that is not kept yet
    Marks refused_;  // have one that cannot be kept
    Marks former_;   // of the table of former names: have a record, which is to be removed
    Pending pending_;
    unsigned next_ = 0;
    unsigned tries_ = 0;
    ParameterStatus counts_{};
    ParameterStatus reported_{};
    bool has_reported_ = false;
};

}  // namespace stator::apps::parameters
