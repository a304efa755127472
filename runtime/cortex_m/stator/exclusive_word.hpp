// Words that tasks of all levels share for counting, where nothing else is ordered by them.
#pragma once

#include <cstdint>

namespace stator {

// One that is changed only if no exception came between its load and its store: the processor
// forgets the exclusive load at each exception, entry and return, so that the store fails (ARM DDI
// 0403E, A3.4.4). What is read between the two is of one moment. Any context.
class ExclusiveWord {
  public:
    [[gnu::always_inline]] uint32_t load_exclusive() const {
        uint32_t value = 0;
        asm volatile("ldrex %0, [%1]" : "=r"(value) : "r"(&value_), "m"(value_));
        return value;
    }
    // False: it was not stored. Tested in here, as the compiler would keep the status as a zero.
    [[gnu::always_inline]] bool store_exclusive(uint32_t value) {
        uint32_t status;
        asm volatile goto("strex %0, %3, [%2]\n\tcmp %0, #0\n\tbne %l[failed]"
                          : "=&r"(status), "+m"(value_)
                          : "r"(&value_), "r"(value)
                          : "cc"
                          : failed);
        return true;
    failed:
        return false;
    }
    uint32_t load() const { return __atomic_load_n(&value_, __ATOMIC_RELAXED); }

  private:
    uint32_t value_ = 0;
};

class RelaxedWord {
  public:
    uint32_t load() const { return __atomic_load_n(&value_, __ATOMIC_RELAXED); }
    void store(uint32_t value) { __atomic_store_n(&value_, value, __ATOMIC_RELAXED); }

  private:
    uint32_t value_ = 0;
};

}  // namespace stator
