// The port of the node that publishes parameters, in a replay: starts with the recorded parameters,
// and compares what it publishes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "stator/parameter_hash.hpp"
#include "stator/parameters.hpp"
#include "stator/replay.hpp"

namespace stator {

class ParameterPort {
  public:
    ParameterPort() = default;
    ParameterPort(const ParameterPort&) = delete;
    ParameterPort& operator=(const ParameterPort&) = delete;

    std::span<const ParameterRow> rows() const { return {table_->rows, table_->row_count}; }

    std::span<const FormerParameter> former() const {
        return {table_->former, table_->former_count};
    }

    ParameterBits value(const ParameterRow& row) const {
        return read_parameter(row, newest(row).data());
    }

    void publish(const ParameterRow& row, ParameterBits value) {
        std::vector<std::byte>& message = newest(row);
        write_parameter(row, message.data(), value);
        const uint64_t now_us = job_->now_us();
        std::memcpy(message.data(), &now_us, sizeof now_us);
        job_->publish(first_tag_ + row.topic, message.data(), message.size());
    }

    // --- for generated wrappers ---
    // `first_tag`: of the first topic of parameters. `newest`: of each topic, kept between
    // activations.
    void connect(replay::Job& job, const ParameterTable& table, unsigned first_tag,
                 std::vector<std::byte>* newest) {
        job_ = &job;
        table_ = &table;
        first_tag_ = first_tag;
        newest_ = newest;
    }

  private:
    std::vector<std::byte>& newest(const ParameterRow& row) const {
        std::vector<std::byte>& sample = newest_[row.topic];
        if (sample.empty()) sample = job_->first_sample(first_tag_ + row.topic);
        return sample;
    }

    const ParameterTable* table_ = nullptr;
    replay::Job* job_ = nullptr;
    std::vector<std::byte>* newest_ = nullptr;
    unsigned first_tag_ = 0;
};

}  // namespace stator
