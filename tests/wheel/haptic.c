/* Library with the interface of SDL2's joysticks and haptics that logs its calls, with the bytes of each effect. The test builds it
 * with the system's cc. -DLACKING leaves one function out, -DROOM=n limits the number of effects, -DFIRST=n sets the first effect id,
 * -DSTUCK runs no effect, -DVENDOR=n -DPRODUCT=n set the wheel's ids. Calls are also written to the file HAPTIC_LOG, line by line, for a test that watches another process. */
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef VENDOR
#define VENDOR 0x046d
#define PRODUCT 0xc24f
#endif

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static char text[1 << 20];
static size_t end;
static unsigned abilities = 1 | 1 << 12 | 1 << 13;
static int motor = 1;

static void note(const char *format, ...) {
    const char *name = getenv("HAPTIC_LOG");
    va_list rest;
    pthread_mutex_lock(&lock);
    /* A process that logs to a file makes more calls than fit into `text`. */
    if (name) end = 0;
    va_start(rest, format);
    const char *line = text + end;
    end += vsnprintf(text + end, sizeof text - end, format, rest);
    va_end(rest);
    FILE *file = name ? fopen(name, "a") : NULL;
    if (file) {
        fputs(line, file);
        fclose(file);
    }
    pthread_mutex_unlock(&lock);
}

static void effect(const char *what, int id, const uint8_t *bytes) {
    char hex[145];
    for (int i = 0; i < 72; i++) snprintf(hex + 2 * i, 3, "%02x", bytes[i]);
    note("%s %d %s\n", what, id, hex);
}

/* For the test: the calls since the last time, and the abilities of the wheel. */
const char *taken(void) {
    static char out[1 << 20];
    pthread_mutex_lock(&lock);
    memcpy(out, text, end);
    out[end] = 0;
    end = 0;
    pthread_mutex_unlock(&lock);
    return out;
}
void set_abilities(unsigned can, int has_motor) { abilities = can, motor = has_motor; }

void SDL_SetMainReady(void) { note("ready\n"); }
int SDL_SetHint(const char *name, const char *value) { return note("hint %s %s\n", name, value), 1; }
int SDL_InitSubSystem(uint32_t flags) { return note("init %x\n", flags), 0; }
void SDL_QuitSubSystem(uint32_t flags) { note("quit %x\n", flags); }
const char *SDL_GetError(void) { return "the recorder says no"; }
int SDL_NumJoysticks(void) { return 2; }
uint16_t SDL_JoystickGetDeviceVendor(int index) { return index == 1 ? VENDOR : 0x045e; }
uint16_t SDL_JoystickGetDeviceProduct(int index) { return index == 1 ? PRODUCT : 0x028e; }
void *SDL_JoystickOpen(int index) { return note("joystick %d\n", index), (void *)(intptr_t)(16 + index); }
void SDL_JoystickClose(void *joystick) { note("close joystick %d\n", (int)(intptr_t)joystick - 16); }
void *SDL_HapticOpenFromJoystick(void *joystick) {
    note("haptic of %d\n", (int)(intptr_t)joystick - 16);
    return motor ? (void *)32 : NULL;
}
void SDL_HapticClose(void *haptic) { note("close haptic\n"); }
unsigned SDL_HapticQuery(void *haptic) { return abilities; }
int SDL_HapticSetGain(void *haptic, int gain) { return note("gain %d\n", gain), 0; }
int SDL_HapticSetAutocenter(void *haptic, int share) { return note("autocentre %d\n", share), 0; }
#ifndef ROOM
#define ROOM 1000
#endif
#ifndef FIRST
#define FIRST 3
#endif
int SDL_HapticNewEffect(void *haptic, void *bytes) {
    static int next = FIRST;
    if (next >= FIRST + ROOM) return -1;
    return effect("new", next, bytes), next++;
}
int SDL_HapticUpdateEffect(void *haptic, int id, void *bytes) { return effect("update", id, bytes), 0; }
#ifndef LACKING
int SDL_HapticRunEffect(void *haptic, int id, uint32_t times) {
#ifdef STUCK
    return -1;
#endif
    return note("run %d %x\n", id, times), 0;
}
#endif
int SDL_HapticStopEffect(void *haptic, int id) { return note("stop %d\n", id), 0; }
void SDL_HapticDestroyEffect(void *haptic, int id) { note("destroy %d\n", id); }
