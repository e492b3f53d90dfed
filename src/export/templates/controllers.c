/* Written by muspin; see controllers.h. */
#include "controllers.h"
{% for kind in kinds %}
#ifndef MUSPIN_NO_{{ kind.NAME }}
{%- for c in controllers %}
static void {{ c.name }}_{{ kind.name }}_init_entry(controllers_{{ kind.name }}_states *states)
{
    {{ c.name }}_{{ kind.name }}_init(&states->{{ c.name }});
}

static void {{ c.name }}_{{ kind.name }}_output_entry(controllers_{{ kind.name }}_states *states, const {{ kind.value }} *y, {{ kind.value }} *u)
{
    {{ c.name }}_{{ kind.name }}_output(&states->{{ c.name }}, y, u);
}

static void {{ c.name }}_{{ kind.name }}_update_entry(controllers_{{ kind.name }}_states *states)
{
    {{ c.name }}_{{ kind.name }}_update(&states->{{ c.name }});
}

static void {{ c.name }}_{{ kind.name }}_hand_over_entry(controllers_{{ kind.name }}_states *states, const {{ kind.value }} *y, const {{ kind.value }} *u)
{
    {{ c.name }}_{{ kind.name }}_init(&states->{{ c.name }});
    {{ c.name }}_{{ kind.name }}_hand_over(&states->{{ c.name }}, y, u);
}
{% endfor %}
const controllers_{{ kind.name }}_entry controllers_{{ kind.name }}_table[CONTROLLERS_COUNT] = {
{%- for c in controllers %}
    { "{{ c.name }}", {{ c.NAME }}_INPUT_SHA256, {{ c.NAME }}_VERIFIED, {{ c.name }}_{{ kind.name }}_init_entry,
      {{ c.name }}_{{ kind.name }}_output_entry, {{ c.name }}_{{ kind.name }}_update_entry, {{ c.name }}_{{ kind.name }}_hand_over_entry },
{%- endfor %}
};

int controllers_{{ kind.name }}_init(controllers_{{ kind.name }} *c, int number)
{
    int i;
    if (number < 0 || number >= CONTROLLERS_COUNT) {
        return -1;
    }
    c->active = number;
    for (i = 0; i < {{ outputs }}; ++i) {
        c->u[i] = 0;
    }
    controllers_{{ kind.name }}_table[number].init(&c->states);
    return 0;
}

void controllers_{{ kind.name }}_output(controllers_{{ kind.name }} *c, const {{ kind.value }} y[{{ inputs }}], {{ kind.value }} u[{{ outputs }}])
{
    int i;
    controllers_{{ kind.name }}_table[c->active].output(&c->states, y, u);
    for (i = 0; i < {{ outputs }}; ++i) {
        c->u[i] = u[i];
    }
}

void controllers_{{ kind.name }}_update(controllers_{{ kind.name }} *c)
{
    controllers_{{ kind.name }}_table[c->active].update(&c->states);
}

int controllers_{{ kind.name }}_change(controllers_{{ kind.name }} *c, int number, const {{ kind.value }} y[{{ inputs }}])
{
    if (number < 0 || number >= CONTROLLERS_COUNT) {
        return -1;
    }
    c->active = number;
    controllers_{{ kind.name }}_table[number].hand_over(&c->states, y, c->u);
    return 0;
}
#endif
{% endfor %}
