/* Second-order sections of {{ controller }}, axis by axis, for the filters of firmware libraries; written by muspin.
 * Displacement in m, current in A. The first section takes the displacement, each next one the output before it.
 * These filters neither limit the current nor hold invalid samples: do both around them.
 * Every table was compared with the controller as its numbers are held, from far below its slowest pole to the Nyquist
 * frequency; the largest change, relative to the response at that frequency:
{%- for axis in single %}
 *   {{ axis.name }}: {{ axis.change }} at {{ axis.frequency }} Hz, float
{%- endfor %}
{%- for axis in double %}
 *   {{ axis.name }}: {{ axis.change }} at {{ axis.frequency }} Hz, double
{%- endfor %}
{%- for note in notes %}
 * {{ note }}.
{%- endfor %}
 */
#ifndef {{ NAME }}_SECTIONS_H
#define {{ NAME }}_SECTIONS_H
{% for axis in single %}
#define {{ NAME }}_SECTIONS_{{ axis.NAME }} {{ axis.count }}
{%- endfor %}
{%- for axis in double %}
#define {{ NAME }}_SECTIONS_{{ axis.NAME }} {{ axis.count }}
{%- endfor %}
{%- if single %}

/* CMSIS-DSP, arm_biquad_cascade_df2T_init_f32: b0, b1, b2, -a1, -a2 of every section. */
{%- for axis in single %}
static const float {{ name }}_cmsis_{{ axis.name }}[{{ 5 * axis.count }}] = {
{%- for section in axis.cmsis %}
    {{ section }},
{%- endfor %}
};
{%- endfor %}

/* TI Digital Control Library, one DCL_DF22 a section: b0, b1, b2, a1, a2. */
{%- for axis in single %}
static const float {{ name }}_dcl_{{ axis.name }}[{{ axis.count }}][5] = {
{%- for section in axis.dcl %}
    { {{ section }} },
{%- endfor %}
};
{%- endfor %}
{%- endif %}
{%- if double %}

/* CMSIS-DSP, arm_biquad_cascade_df2T_init_f64: b0, b1, b2, -a1, -a2 of every section. */
{%- for axis in double %}
static const double {{ name }}_f64_{{ axis.name }}[{{ 5 * axis.count }}] = {
{%- for section in axis.cmsis %}
    {{ section }},
{%- endfor %}
};
{%- endfor %}
{%- endif %}

#endif
