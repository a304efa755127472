/*
 * The STM32F427 for QEMU: the core and its memories. Every access to a peripheral is a request
 * over a socket to a model of the chip, which is a program of its own.
 *
 * SPDX-License-Identifier: GPL-2.0-or-later
 */
#include "qemu/osdep.h"

#include <sys/un.h>

#include "cpu.h"
#include "exec/address-spaces.h"
#include "exec/cpu-common.h"
#include "hw/arm/armv7m.h"
#include "hw/arm/boot.h"
#include "hw/boards.h"
#include "hw/core/cpu.h"
#include "hw/irq.h"
#include "hw/qdev-clock.h"
#include "hw/qdev-properties.h"
#include "qapi/error.h"
#include "qemu/cutils.h"
#include "qemu/error-report.h"
#include "qemu/host-utils.h"
#include "qemu/timer.h"
#include "system/reset.h"
#include "system/runstate.h"

enum { LINES = 96, WORDS = LINES / 32, AT_ONCE = 65536, KNOWN = 2, MODEL_STOPPED = 3 };

/* The two messages are laid out the same way in the model (boards/chip/chip/wire.hpp). */
typedef enum { READ, WRITE, DUE, RESET } RequestKind;
typedef struct {
    uint8_t kind, size;
    uint16_t unused;
    uint32_t address;
    uint64_t now_ns;
    uint32_t value, unused2;
} Request;

/* A register that counts by itself, read here without asking until then: `first` at `from_ns`, and
 * one more each `divider` clocks. Divider 0: none. */
typedef struct {
    uint32_t address, first, clock_hz, divider;
    uint64_t from_ns, until_ns;
} Counter;

/* FETCH and STORE are the model's DMA in the machine's memory: they come before the answer. */
typedef enum { ANSWER, FETCH, STORE, STOP } ReplyKind;
typedef struct {
    uint32_t kind, value, address, length;
    uint32_t levels[WORDS]; /* of the interrupt lines */
    uint32_t clock_hz;      /* of the core */
    uint64_t next_ns;       /* when the model wants to be asked; 0: never */
    uint32_t reset, unused; /* whether the model resets the chip: its watchdog */
    Counter known[KNOWN];
} Reply;

typedef struct {
    uint32_t base, size;
    const char *name;
} Area;
/* What the model has. The last one is the part of the debug unit that names the chip. */
static const Area areas[] = {
    { 0x40000000, 0x100000, "peripherals" },
    { 0x50000000, 0x61000, "usb" },
    { 0x1fff0000, 0x10000, "system" },
    { 0xe0042000, 0x400, "debug" },
};
enum { FLASH = 0x08000000, FLASH_SIZE = 0x200000 };
enum { TRACE = 0xe0001000, TRACE_SIZE = 0x1000, CYCLES = 4 };

static int model = -1;
static uint32_t levels[WORDS];
static qemu_irq lines[LINES];
static QEMUTimer *timer;
static Clock *core_clock;
static Counter known[KNOWN];
static char *model_path;
static uint32_t vectors = FLASH;

static G_NORETURN void stop(const char *why)
{
    CPUState *cpu = current_cpu;
    if (cpu && cpu->mem_io_pc) {
        cpu_restore_state(cpu, cpu->mem_io_pc);
        CPUARMState *env = cpu_env(cpu);
        error_report("%s; pc 0x%08x, lr 0x%08x", why, env->regs[15], env->regs[14]);
    } else {
        error_report("%s", why);
    }
    exit(MODEL_STOPPED);
}

static void pass(void *bytes, size_t count, bool sends)
{
    while (count) {
        ssize_t done = sends ? send(model, bytes, count, MSG_NOSIGNAL)
                             : recv(model, bytes, count, MSG_WAITALL);
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done <= 0) {
            stop("the model of the chip has ended");
        }
        bytes = (char *)bytes + done;
        count -= done;
    }
}

static uint32_t ask(RequestKind kind, unsigned size, uint32_t address, uint32_t value)
{
    static uint8_t buffer[AT_ONCE];
    Request request = {
        .kind = kind, .size = size, .address = address, .value = value,
        .now_ns = qemu_clock_get_ns(QEMU_CLOCK_VIRTUAL),
    };
    Reply reply;

    pass(&request, sizeof(request), true);
    for (;;) {
        pass(&reply, sizeof(reply), false);
        if (reply.kind == STOP && reply.value == 0) {
            exit(0);
        }
        if (reply.kind == STOP) {
            stop("stopped by the model of the chip");
        }
        if (reply.kind == ANSWER) {
            break;
        }
        if (reply.length > AT_ONCE) {
            stop("the model of the chip passes too many bytes at once");
        }
        if (reply.kind == FETCH) {
            address_space_read(&address_space_memory, reply.address, MEMTXATTRS_UNSPECIFIED,
                               buffer, reply.length);
            pass(buffer, reply.length, true);
        } else {
            pass(buffer, reply.length, false);
            address_space_write(&address_space_memory, reply.address, MEMTXATTRS_UNSPECIFIED,
                                buffer, reply.length);
        }
    }
    for (int word = 0; word < WORDS; word++) {
        uint32_t changed = levels[word] ^ reply.levels[word];
        levels[word] = reply.levels[word];
        for (; changed; changed &= changed - 1) {
            int bit = ctz32(changed);
            qemu_set_irq(lines[word * 32 + bit], (reply.levels[word] >> bit) & 1);
        }
    }
    if (reply.clock_hz != clock_get_hz(core_clock)) {
        clock_update_hz(core_clock, reply.clock_hz);
    }
    if (reply.next_ns) {
        timer_mod(timer, reply.next_ns);
    } else {
        timer_del(timer);
    }
    memcpy(known, reply.known, sizeof(known));
    if (reply.reset) {
        qemu_system_reset_request(SHUTDOWN_CAUSE_GUEST_RESET);
    }
    return reply.value;
}

static void due(void *unused)
{
    ask(DUE, 0, 0, 0);
}

static void reset(void *unused)
{
    ask(RESET, 0, 0, 0);
}

static uint64_t read_area(void *base, hwaddr offset, unsigned size)
{
    uint32_t address = (uintptr_t)base + offset;
    uint64_t now_ns = qemu_clock_get_ns(QEMU_CLOCK_VIRTUAL);

    for (const Counter *c = known; c < known + KNOWN && size == 4; c++) {
        if (c->divider && address == c->address && now_ns < c->until_ns) {
            uint64_t clocks = muldiv64(now_ns - c->from_ns, c->clock_hz, NANOSECONDS_PER_SECOND);
            return c->first + clocks / c->divider;
        }
    }
    return ask(READ, size, address, 0);
}

static void write_area(void *base, hwaddr offset, uint64_t value, unsigned size)
{
    ask(WRITE, size, (uintptr_t)base + offset, value);
}

static const MemoryRegionOps to_model = {
    .read = read_area,
    .write = write_area,
    .endianness = DEVICE_LITTLE_ENDIAN,
    .valid = { .min_access_size = 1, .max_access_size = 4, .unaligned = true },
    .impl = { .min_access_size = 1, .max_access_size = 4, .unaligned = true },
};

/* The core's cycle counter, which QEMU lacks. It runs with the core's clock from reset on. */
static uint64_t read_trace(void *unused, hwaddr offset, unsigned size)
{
    uint64_t now_ns = qemu_clock_get_ns(QEMU_CLOCK_VIRTUAL);
    return offset == CYCLES ? (uint32_t)clock_ns_to_ticks(core_clock, now_ns) : 0;
}

static void write_trace(void *unused, hwaddr offset, uint64_t value, unsigned size)
{
}

static const MemoryRegionOps trace = {
    .read = read_trace,
    .write = write_trace,
    .endianness = DEVICE_LITTLE_ENDIAN,
};

static void add_memory(uint32_t base, uint32_t size, const char *name)
{
    MemoryRegion *region = g_new0(MemoryRegion, 1);
    memory_region_init_ram(region, NULL, name, size, &error_fatal);
    memory_region_add_subregion(get_system_memory(), base, region);
}

/* Reads are the memory's; writes go to the model, which knows the flash controller. */
static void add_flash(void)
{
    MemoryRegion *flash = g_new0(MemoryRegion, 1), *alias = g_new0(MemoryRegion, 1);
    memory_region_init_rom_device(flash, NULL, &to_model, (void *)(uintptr_t)FLASH, "flash",
                                  FLASH_SIZE, &error_fatal);
    memory_region_add_subregion(get_system_memory(), FLASH, flash);
    memory_region_init_alias(alias, NULL, "alias", flash, 0, FLASH_SIZE);
    memory_region_add_subregion(get_system_memory(), 0, alias);
}

/* Over the core's private area, where QEMU has what answers with 0. */
static void add_areas(MemoryRegion *memory)
{
    MemoryRegion *region = g_new0(MemoryRegion, 1);
    memory_region_init_io(region, NULL, &trace, NULL, "trace", TRACE_SIZE);
    memory_region_add_subregion_overlap(memory, TRACE, region, 1);
    for (int i = 0; i < ARRAY_SIZE(areas); i++) {
        region = g_new0(MemoryRegion, 1);
        memory_region_init_io(region, NULL, &to_model, (void *)(uintptr_t)areas[i].base,
                              areas[i].name, areas[i].size);
        memory_region_add_subregion_overlap(memory, areas[i].base, region, 1);
    }
}

static void connect_model(void)
{
    struct sockaddr_un place = { .sun_family = AF_UNIX };
    if (!model_path) {
        error_report("missing machine option 'model': the socket of the model of the chip");
        exit(1);
    }
    pstrcpy(place.sun_path, sizeof(place.sun_path), model_path);
    model = socket(AF_UNIX, SOCK_STREAM, 0);
    if (model < 0 || connect(model, (struct sockaddr *)&place, sizeof(place))) {
        error_report("cannot connect to the model of the chip at %s", model_path);
        exit(1);
    }
}

static void start_machine(MachineState *machine)
{
    MemoryRegion *memory = get_system_memory();
    DeviceState *core = qdev_new(TYPE_ARMV7M);

    add_flash();
    add_memory(0x20000000, 0x30000, "ram");
    add_memory(0x10000000, 0x10000, "ccm");
    core_clock = clock_new(OBJECT(machine), "core");
    clock_set_hz(core_clock, 16000000);
    object_property_add_child(OBJECT(machine), "armv7m", OBJECT(core));
    qdev_prop_set_uint32(core, "num-irq", LINES);
    qdev_prop_set_uint8(core, "num-prio-bits", 4);
    qdev_prop_set_string(core, "cpu-type", ARM_CPU_TYPE_NAME("cortex-m4"));
    qdev_prop_set_bit(core, "enable-bitband", true);
    qdev_prop_set_uint32(core, "init-nsvtor", vectors);
    qdev_connect_clock_in(core, "cpuclk", core_clock);
    object_property_set_link(OBJECT(core), "memory", OBJECT(memory), &error_abort);
    sysbus_realize_and_unref(SYS_BUS_DEVICE(core), &error_fatal);
    add_areas(&ARMV7M(core)->container);
    for (int i = 0; i < LINES; i++) {
        lines[i] = qdev_get_gpio_in(core, i);
    }

    timer = timer_new_ns(QEMU_CLOCK_VIRTUAL, due, NULL);
    connect_model();
    armv7m_load_kernel(ARMV7M(core)->cpu, machine->kernel_filename, vectors,
                       FLASH + FLASH_SIZE - vectors);
    qemu_register_reset(reset, NULL);
}

static char *get_model(Object *machine, Error **errors)
{
    return g_strdup(model_path);
}

static void set_model(Object *machine, const char *value, Error **errors)
{
    g_free(model_path);
    model_path = g_strdup(value);
}

static void init_class(MachineClass *machine)
{
    static const char *const types[] = { ARM_CPU_TYPE_NAME("cortex-m4"), NULL };
    ObjectClass *class = OBJECT_CLASS(machine);

    machine->desc = "STM32F427 with its peripherals in a model outside";
    machine->init = start_machine;
    machine->valid_cpu_types = types;
    machine->default_ram_size = 0;
    object_class_property_add_str(class, "model", get_model, set_model);
    object_class_property_set_description(class, "model", "socket of the model of the chip");
    object_class_property_add_uint32_ptr(class, "vectors", &vectors, OBJ_PROP_FLAG_READWRITE);
    object_class_property_set_description(class, "vectors", "where the image lies in the flash");
}

DEFINE_MACHINE("stm32f427", init_class)
