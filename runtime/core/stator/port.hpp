// Ports: what a node sees of its topics. Typed by the node's interface, ignorant of topic names,
// rates and priorities. Generated wrappers fill them before `step` and let go of them after it.
// What a port takes and publishes passes its tap, which is the build's (runtime/recording).
#pragma once

#include <cstdint>
#include <new>
#include <type_traits>

#include "stator/running.hpp"
#include "stator/tap.hpp"
#include "stator/topic.hpp"

namespace stator {

inline constexpr uint32_t kNoAgeLimit = UINT32_MAX;

// Whether the ports of this file call the code that they share: so they do in tasks that seldom
// run, which are compiled for size (docs/decisions/0027). Elsewhere all of it is inlined.
#ifdef __OPTIMIZE_SIZE__
constexpr bool kSharesPortCode = true;
#else
constexpr bool kSharesPortCode = false;
#endif

// What an input is whatever its message. A sample begins with its timestamp.
class AnyInput {
  public:
    AnyInput(const AnyInput&) = delete;
    AnyInput& operator=(const AnyInput&) = delete;

    // True if there is a sample, and it is not older than the graph's `max_age`.
    explicit operator bool() const { return sample_ != nullptr; }

    // True if there is a sample, and no earlier activation of this node has seen it.
    [[gnu::always_inline]] bool is_new() const {
        is_asked_ = true;
        if (sample_ == nullptr) return false;
        return seen_ == nullptr ? is_new_ : number() != *seen_;
    }
    // Samples that passed unread since the one seen before; in a queue input, summed over `next()`.
    [[gnu::always_inline]] uint32_t lost() const {
        is_asked_ = true;
        return passed();
    }
    // Number of the sample on its topic, from 1, modulo 2^32; 0 without a sample.
    [[gnu::always_inline]] uint32_t number() const {
        if (sample_ == nullptr || topic_ == nullptr) return 0;
        return number_of(*topic_, pin_, is_woken_);
    }

    // --- for generated wrappers ---
    // `marks`: a publisher outranks the reader (one_core_topic.hpp).

    // Where what this port takes is recorded; nothing in builds that do not record.
    [[gnu::always_inline]] Tap& tap() { return tap_; }
    // Consumes the oldest unread sample, if there is one.
    [[gnu::always_inline]] void take_trigger(const Topic& topic, uint32_t& cursor,
                                             bool marks = true) {
        topic_ = &topic;
        marks_ = marks;
        if (!take_next(topic, cursor, lost_, pin_, marks)) return;
        hold();
        is_new_ = true;
    }
    // The same where the newest sample is the one that woke this activation, and no other could.
    [[gnu::always_inline]] void take_woken(const Topic& topic, uint32_t& seen) {
        topic_ = &topic;
        marks_ = false;
        seen_ = &seen;
        is_woken_ = true;
        stator::take_woken(topic, seen, pin_);
        hold();
    }
    // Takes the newest sample if it is at most `max_age_us` old at `now_us`. `seen` is the number
    // of the one seen before, brought up to date when the port is let go.
    [[gnu::always_inline]] void take_latest(const Topic& topic, uint32_t& seen, uint64_t now_us,
                                            uint32_t max_age_us = kNoAgeLimit, bool marks = true) {
        if (kSharesPortCode) return take_latest_shared(topic, seen, now_us, max_age_us, marks);
        take_latest_here(topic, seen, now_us, max_age_us, marks);
    }
    [[gnu::always_inline]] void open_queue(const Topic& topic, uint32_t& cursor, uint64_t now_us,
                                           uint32_t max_age_us = kNoAgeLimit, bool marks = true) {
        topic_ = &topic;
        marks_ = marks;
        cursor_ = &cursor;
        now_us_ = now_us;
        max_age_us_ = max_age_us;
    }
    // Lets a sample go that is older than the graph allows.
    [[gnu::always_inline]] void limit_age(uint64_t now_us, uint32_t max_age_us) {
        if (sample_ == nullptr || is_young_enough(now_us, max_age_us)) return;
        lost_ = passed();
        if (seen_ != nullptr) *seen_ = number();
        drop();
    }

  protected:
    // Not defaulted: `Input<Message> port{};` then would clear all of it before.
    [[gnu::always_inline]] AnyInput() {}
    AnyInput(const std::byte* sample, bool is_new, uint32_t lost)
        : sample_(sample), lost_(lost), is_new_(is_new) {}
    [[gnu::always_inline]] ~AnyInput() { kSharesPortCode ? end_shared() : end_here(); }

    const std::byte* sample() const { return sample_; }

    [[gnu::noinline]] bool next_shared() { return next_here(); }
    [[gnu::always_inline]] bool next_here() {
        if (cursor_ == nullptr) {
            const bool first = !is_consumed_ && is_new();
            is_consumed_ = true;
            return first;
        }
        drop();
        while (take_next(*topic_, *cursor_, lost_, pin_, marks_)) {
            hold();
            is_new_ = true;
            if (is_young_enough(now_us_, max_age_us_)) return true;
            drop();
        }
        return false;
    }

  private:
    [[gnu::noinline]] void take_latest_shared(const Topic& topic, uint32_t& seen, uint64_t now_us,
                                              uint32_t max_age_us, bool marks) {
        take_latest_here(topic, seen, now_us, max_age_us, marks);
    }
    [[gnu::noinline]] void end_shared() { end_here(); }

    [[gnu::always_inline]] void take_latest_here(const Topic& topic, uint32_t& seen,
                                                 uint64_t now_us, uint32_t max_age_us, bool marks) {
        topic_ = &topic;
        marks_ = marks;
        seen_ = &seen;
        if (!stator::take_latest(topic, seen, pin_, marks)) return;
        hold();
        limit_age(now_us, max_age_us);
    }
    [[gnu::always_inline]] void end_here() {
        note_seen();
        drop();
    }
    [[gnu::always_inline]] uint32_t passed() const {
        if (seen_ == nullptr || sample_ == nullptr) return lost_;
        const uint32_t count = number() - *seen_;
        return count == 0 ? 0 : count - 1;
    }
    // Does nothing where the compiler sees that the node never asks what is new: there the number
    // is of no use.
    [[gnu::always_inline]] void note_seen() {
        if (!kTakesNeedSeen && __builtin_constant_p(is_asked_) && !is_asked_) return;
        if (seen_ != nullptr && sample_ != nullptr) *seen_ = number();
    }
    [[gnu::always_inline]] void hold() {
        sample_ = sample_of(*topic_, pin_, is_woken_);
        if constexpr (kRecords) {
            const uint32_t number = number_of(*topic_, pin_, is_woken_);
            cursor_ != nullptr ? tap_.takes(number) : tap_.notes(number);
        }
    }
    [[gnu::always_inline]] void drop() {
        // On one core the newest is let go without a test whether there was one.
        const bool is_taken = (!kTakesNeedSeen && seen_ != nullptr) || sample_ != nullptr;
        if (topic_ != nullptr && is_taken) release(*topic_, pin_, marks_);
        sample_ = nullptr;
    }
    [[gnu::always_inline]] bool is_young_enough(uint64_t now_us, uint32_t max_age_us) const {
        if (max_age_us == kNoAgeLimit) return true;
        const uint64_t timestamp_us = *reinterpret_cast<const uint64_t*>(sample_);
        return now_us < timestamp_us || now_us - timestamp_us <= max_age_us;
    }

    const std::byte* sample_ = nullptr;
    const Topic* topic_ = nullptr;
    uint32_t* cursor_ = nullptr;  // of a queue
    uint32_t* seen_ = nullptr;    // of an input that reads the newest
    uint32_t lost_ = 0;
    bool marks_ = true;
    bool is_woken_ = false;
    bool is_new_ = false;
    bool is_consumed_ = false;
    mutable bool is_asked_ = false;
    [[no_unique_address]] Tap tap_;
    // Set where they are used: clearing them takes time where a node is not inlined.
    Pin pin_;
    uint64_t now_us_;  // of a queue
    uint32_t max_age_us_;
};

// One input of a node. A trigger input holds the sample that this activation consumes, a latest
// input the newest one; both stay valid until `step` returns. A queue input is absent until
// `next()`, which moves on to the oldest unread sample. Context: the activation it belongs to.
template <class Message>
class Input : public AnyInput {
  public:
    [[gnu::always_inline]] Input() {}
    // A port of a node, which has its name.
    [[gnu::always_inline]] explicit Input(const char* name) : name_(name) {}
    // A port of a test: holds `sample`, which must outlive it.
    explicit Input(const Message& sample, bool is_new = true, uint32_t lost = 0)
        : AnyInput(reinterpret_cast<const std::byte*>(&sample), is_new, lost) {}
    Input(const Input&) = delete;
    Input& operator=(const Input&) = delete;
    [[gnu::always_inline]] ~Input() {}  // not defaulted: it is inlined with its base

    // Moves on to the next unread sample: true while there is one. Other inputs say true once, for
    // a new sample, so that a node reads every kind of input alike.
    bool next() { return kSharesPortCode ? next_shared() : next_here(); }

    // Only where there is a sample; host programs check it.
    const Message& operator*() const { return *present(); }
    const Message* operator->() const { return present(); }

  private:
    [[gnu::always_inline]] const Message* present() const {
        if (kChecksInputs && !*this) [[unlikely]] {
            fail_absent(name_.get());
        }
        return reinterpret_cast<const Message*>(sample());
    }

    [[no_unique_address]] PortName name_;
};

// What an output is whatever its message.
class AnyOutput {
  public:
    AnyOutput(const AnyOutput&) = delete;
    AnyOutput& operator=(const AnyOutput&) = delete;

    bool is_connected() const { return topic_ != nullptr; }

    // --- for generated wrappers ---
    [[gnu::always_inline]] Tap& tap() { return tap_; }
    [[gnu::always_inline]] void connect(const Topic& topic, uint64_t now_us, bool keep,
                                        uint16_t burst = 1) {
        topic_ = &topic;
        now_us_ = now_us;
        keep_ = keep;
        left_ = burst;
    }
    // Publications of this activation that were refused.
    uint16_t refused() const { return refused_; }

  protected:
    // A sample that is being built.
    struct Building {
        Loan loaned;
        std::byte* slot;
        uint16_t left;
    };

    [[gnu::always_inline]] AnyOutput() {}

    // False: it is refused.
    [[gnu::always_inline]] bool begin(Building& building) {
        return kSharesPortCode ? begin_shared(building) : begin_here(building);
    }
    [[gnu::always_inline]] void end(const Building& building, std::byte* sample, uint32_t bytes) {
        kSharesPortCode ? end_shared(building, sample, bytes) : end_here(building, sample, bytes);
    }
    uint64_t now_us() const { return now_us_; }

  private:
    [[gnu::noinline]] bool begin_shared(Building& building) { return begin_here(building); }
    [[gnu::noinline]] void end_shared(const Building& building, std::byte* sample, uint32_t bytes) {
        end_here(building, sample, bytes);
    }

    [[gnu::always_inline]] bool begin_here(Building& building) {
        if (left_ == 0) [[unlikely]] {
            ++refused_;
            return false;
        }
        building.left = static_cast<uint16_t>(left_ - 1);
        left_ = 0;
        building.loaned = loan(*topic_, keep_);
        building.slot = slot_at(*topic_, building.loaned.slot);
        return true;
    }
    [[gnu::always_inline]] void end_here(const Building& building, std::byte* sample,
                                         uint32_t bytes) {
        left_ = building.left;
        tap_.builds(sample);
        // Those whom it wakes do not wait for the record, if the sample lasts.
        const bool is_kept = is_kept_for_publisher(*topic_);
        const uint32_t hash = is_kept ? 0 : tap_.commits(sample, bytes);
        const uint32_t number = commit(*topic_, building.loaned, sample);
        activate(*topic_, now_us_);
        if (is_kept) {
            tap_.published(sample, bytes, number);
        } else {
            tap_.committed(hash, number);
        }
    }

    const Topic* topic_ = nullptr;
    uint64_t now_us_ = 0;
    uint16_t left_ = 0;  // publications; none while it is not connected
    uint16_t refused_ = 0;
    bool keep_ = false;
    [[no_unique_address]] Tap tap_;
};

// One output of a node. May be unconnected: then publishing does nothing.
template <class Message>
class Output : public AnyOutput {
  public:
    [[gnu::always_inline]] Output() {}

    // Publishes what `make()` returns, built in its slot: `publish([&] { return Message{...}; })`.
    // Sets `timestamp` to the activation's `now` and wakes the subscribers; more urgent ones run
    // before this returns. Refused and counted beyond the output's `burst`, for which there may be
    // no slot, and inside `make`, where it would build in the same slot.
    template <class Make>
    requires std::is_invocable_r_v<Message, Make>
    [[gnu::always_inline]] void publish(Make make) {
        Building building;
        if (!begin(building)) return;
        std::byte* slot = building.slot;
        asm("" : "+r"(slot));  // one register reaches all fields: computed once
        auto* const message = new (slot) Message(make());
        message->timestamp = now_us();
        end(building, slot, sizeof(Message));
    }

    // Publishes what has its `timestamp` already: what another machine published, or another node.
    [[gnu::always_inline]] void forward(const Message& message) {
        Building building;
        if (!begin(building)) return;
        auto* const copy = new (building.slot) Message(message);
        end(building, reinterpret_cast<std::byte*>(copy), sizeof(Message));
    }

    // A message is built in its slot, never copied there.
    template <class Other>
    requires(!std::is_invocable_r_v<Message, Other>) void publish(const Other& /*other*/) {
        static_assert(sizeof(Other) == 0,
                      "publish expects a function that returns the output's message: write "
                      "publish([&] { return Message{.field = value}; })");
    }
};

}  // namespace stator
