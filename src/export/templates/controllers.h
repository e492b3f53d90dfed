/* Several controllers of one spindle, exchanged at run time without a jump of the currents; written by muspin.
{%- for c in controllers %}
 * {{ loop.index0 }} {{ c.name }}: {{ c.controller }}, {{ c.machine }}
{%- endfor %}
 *
 * Call controllers_f32_init() once, controllers_f32_output() and controllers_f32_update() every sample, and between two
 * samples controllers_f32_change() with the displacements of the coming sample. The first output of the new controller
 * repeats the last currents of the old one, within the output limit of the new one.
 * Compile controllers.c and the controller.c of every folder.
 */
#ifndef MUSPIN_CONTROLLERS_H
#define MUSPIN_CONTROLLERS_H
{% for c in controllers %}
#include "{{ c.name }}/controller.h"
{%- endfor %}

#ifdef __cplusplus
extern "C" {
#endif

/* Numbers of the controllers. */
enum {
{%- for c in controllers %}
    CONTROLLERS_{{ c.NAME }} = {{ loop.index0 }},
{%- endfor %}
    CONTROLLERS_COUNT = {{ controllers | length }}
};
{% for kind in kinds %}
#ifndef MUSPIN_NO_{{ kind.NAME }}
/* Room for the states of any of them. */
typedef union {
{%- for c in controllers %}
    {{ c.name }}_{{ kind.name }} {{ c.name }};
{%- endfor %}
} controllers_{{ kind.name }}_states;

/* One controller of the table. */
typedef struct {
    const char *name;
    const char *sha256;
    int verified;
    void (*init)(controllers_{{ kind.name }}_states *states);
    void (*output)(controllers_{{ kind.name }}_states *states, const {{ kind.value }} y[{{ inputs }}], {{ kind.value }} u[{{ outputs }}]);
    void (*update)(controllers_{{ kind.name }}_states *states);
    void (*hand_over)(controllers_{{ kind.name }}_states *states, const {{ kind.value }} y[{{ inputs }}], const {{ kind.value }} u[{{ outputs }}]);
} controllers_{{ kind.name }}_entry;

extern const controllers_{{ kind.name }}_entry controllers_{{ kind.name }}_table[CONTROLLERS_COUNT];

/* The controller that runs, with its states and its last currents. */
typedef struct {
    int active;
    {{ kind.value }} u[{{ outputs }}];
    controllers_{{ kind.name }}_states states;
} controllers_{{ kind.name }};

/* Starts with a controller from zero states. Returns 0, or -1 when there is no such number; nothing changes then. */
int controllers_{{ kind.name }}_init(controllers_{{ kind.name }} *c, int number);
/* The two halves of a sample. */
void controllers_{{ kind.name }}_output(controllers_{{ kind.name }} *c, const {{ kind.value }} y[{{ inputs }}], {{ kind.value }} u[{{ outputs }}]);
void controllers_{{ kind.name }}_update(controllers_{{ kind.name }} *c);
/* Goes on with another controller. Returns 0, or -1 when there is no such number; nothing changes then. */
int controllers_{{ kind.name }}_change(controllers_{{ kind.name }} *c, int number, const {{ kind.value }} y[{{ inputs }}]);
#endif
{% endfor %}
#ifdef __cplusplus
}
#endif

#endif
