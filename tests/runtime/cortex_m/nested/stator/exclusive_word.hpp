// The processor's exclusive load and store: a job that came in between is an exception.
#pragma once

#include <cstdint>

#include "stator/executor.hpp"

namespace stator {

namespace testing {
inline bool is_exclusive = false;  // an exception ends it
}

class ExclusiveWord {
  public:
    uint32_t load_exclusive() const {
        preemption_point();
        testing::is_exclusive = true;
        return value_;
    }
    bool store_exclusive(uint32_t value) {
        preemption_point();
        const bool stores = testing::is_exclusive;
        testing::is_exclusive = false;
        if (stores) value_ = value;
        return stores;
    }
    uint32_t load() const { return value_; }

  private:
    uint32_t value_ = 0;
};

class RelaxedWord {
  public:
    uint32_t load() const {
        preemption_point();
        return value_;
    }
    void store(uint32_t value) {
        preemption_point();
        value_ = value;
    }

  private:
    uint32_t value_ = 0;
};

}  // namespace stator
