// Ports of a replay: to a node the same as those of a flight (runtime/core/stator/port.hpp), but
// fed with the samples that the recorded activation had, and compared with what it published.
#pragma once

#include <cstdint>

#include "stator/replay.hpp"

namespace stator {

inline constexpr uint32_t kNoAgeLimit = UINT32_MAX;

template <class Message>
class Input {
  public:
    Input() = default;
    explicit Input(const char* /*name*/) {}
    Input(const Input&) = delete;
    Input& operator=(const Input&) = delete;

    explicit operator bool() const { return sample_ != nullptr; }
    const Message& operator*() const { return *sample_; }
    const Message* operator->() const { return sample_; }

    bool is_new() const { return is_new_ && sample_ != nullptr; }
    uint32_t lost() const { return lost_; }
    uint32_t number() const { return sample_ == nullptr ? 0 : number_; }

    bool next() {
        if (!is_queue_) {
            const bool first = is_new() && !is_consumed_;
            is_consumed_ = true;
            return first;
        }
        sample_ = nullptr;
        while (take()) {
            if (young_enough()) return true;
            sample_ = nullptr;
        }
        return false;
    }

    // --- for generated wrappers ---
    // `tag`: the port's number in the recording. `cursor`: number of the sample taken before.

    void take_sample(replay::Job& job, unsigned tag, uint32_t& cursor,
                     uint32_t max_age_us = kNoAgeLimit) {
        connect(job, tag, cursor, max_age_us);
        if (take() && !young_enough()) sample_ = nullptr;
    }
    void open_queue(replay::Job& job, unsigned tag, uint32_t& cursor,
                    uint32_t max_age_us = kNoAgeLimit) {
        connect(job, tag, cursor, max_age_us);
        is_queue_ = true;
    }

  private:
    void connect(replay::Job& job, unsigned tag, uint32_t& cursor, uint32_t max_age_us) {
        job_ = &job;
        tag_ = tag;
        cursor_ = &cursor;
        max_age_us_ = max_age_us;
    }
    bool take() {
        const replay::Taken taken = job_->take(tag_);
        sample_ = static_cast<const Message*>(taken.sample);
        if (sample_ == nullptr) return false;
        number_ = taken.number;
        is_new_ = number_ != *cursor_;
        if (is_new_) lost_ += number_ - *cursor_ - 1;
        *cursor_ = number_;
        return true;
    }
    bool young_enough() const {
        const uint64_t now_us = job_->now_us();
        if (max_age_us_ == kNoAgeLimit || now_us < sample_->timestamp) return true;
        return now_us - sample_->timestamp <= max_age_us_;
    }

    const Message* sample_ = nullptr;
    replay::Job* job_ = nullptr;
    uint32_t* cursor_ = nullptr;
    unsigned tag_ = 0;
    uint32_t max_age_us_ = kNoAgeLimit;
    uint32_t lost_ = 0;
    uint32_t number_ = 0;
    bool is_queue_ = false;
    bool is_new_ = false;
    bool is_consumed_ = false;
};

template <class Message>
class Output {
  public:
    Output() = default;
    Output(const Output&) = delete;
    Output& operator=(const Output&) = delete;

    bool is_connected() const { return job_ != nullptr; }

    template <class Make>
    void publish(Make make) {
        if (left_ == 0) return;  // refused, as in the flight
        const unsigned left = left_ - 1;
        left_ = 0;
        Message message(make());
        left_ = left;
        message.timestamp = job_->now_us();
        job_->publish(tag_, &message, sizeof message);
    }

    void forward(const Message& message) {
        if (left_ == 0) return;
        --left_;
        Message copy(message);
        job_->publish(tag_, &copy, sizeof copy);
    }

    // --- for generated wrappers ---
    void connect(replay::Job& job, unsigned tag, unsigned burst = 1) {
        job_ = &job;
        tag_ = tag;
        left_ = burst;
    }

  private:
    replay::Job* job_ = nullptr;
    unsigned tag_ = 0;
    unsigned left_ = 0;
};

}  // namespace stator
