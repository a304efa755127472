// The executor that the explorer puts under the topic code: every access to a shared word asks the
// explorer which more urgent jobs run first.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace stator {

namespace explorer {

// Runs the jobs that the explored schedule puts before the access that follows.
void pass_point();
// What the running job has just read: with the schedule it determines the job's local variables.
void note_load(const void* word, uint32_t value);
void note_store(const void* word, uint32_t value);
// Levels up to the ceiling cannot preempt; returns the ceiling before.
unsigned raise_ceiling(unsigned ceiling);
void restore_ceiling(unsigned ceiling);
// Notes the violation and ends the running job.
[[noreturn]] void fail(const char* what);

// Stands in for the product's `Shared`, which topic.hpp declares after this header: the same
// accesses, seen by the explorer.
template <class Value>
class Word {
  public:
    constexpr Word() = default;
    explicit constexpr Word(Value value) : value_(value) {}
    Value load() const {
        pass_point();
        note_load(this, bits());
        return value_;
    }
    void store(Value value) {
        pass_point();
        value_ = value;
        note_store(this, bits());
    }
    Value peek() const { return value_; }

  private:
    // Pointers lie within a topic, so their lower halves differ.
    uint32_t bits() const {
        if constexpr (sizeof(Value) <= sizeof(uint32_t)) {
            return value_;
        } else {
            return static_cast<uint32_t>(std::bit_cast<uintptr_t>(value_));
        }
    }

    Value value_{};
};

}  // namespace explorer

template <class Value>
class Shared;
template <>
class Shared<uint32_t> : public explorer::Word<uint32_t> {
    using Word::Word;
};
template <>
class Shared<const std::byte*> : public explorer::Word<const std::byte*> {
    using Word::Word;
};
template <>
class Shared<uint8_t> : public explorer::Word<uint8_t> {
    using Word::Word;
};

struct Pend {
    uint32_t word;
    uint64_t mask;
};
inline void set_pending(const Pend&) {}
inline void preempt() {}
inline void preemption_point() {
    explorer::pass_point();
}
inline void require(bool condition, const char* what) {
    if (!condition) explorer::fail(what);
}

class Section {
  public:
    explicit Section(unsigned ceiling) : outer_(explorer::raise_ceiling(ceiling)) {}
    ~Section() { explorer::restore_ceiling(outer_); }
    Section(const Section&) = delete;
    Section& operator=(const Section&) = delete;

  private:
    unsigned outer_;
};

}  // namespace stator
