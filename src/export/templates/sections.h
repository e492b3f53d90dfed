/* Second-order sections of {{ controller }}, axis by axis, for the filters of firmware libraries; written by muspin.
 * Displacement in m, current in A. The first section takes the displacement, each next one the output before it.
 * These filters neither limit the current nor hold invalid samples: do both around them. */
#ifndef {{ NAME }}_SECTIONS_H
#define {{ NAME }}_SECTIONS_H
{% for axis in axes %}
#define {{ NAME }}_SECTIONS_{{ axis.NAME }} {{ axis.count }}
{%- endfor %}

/* CMSIS-DSP, arm_biquad_cascade_df2T_init_f32: b0, b1, b2, -a1, -a2 of every section. */
{%- for axis in axes %}
static const float {{ name }}_cmsis_{{ axis.name }}[{{ 5 * axis.count }}] = {
{%- for section in axis.cmsis %}
    {{ section }},
{%- endfor %}
};
{%- endfor %}

/* TI Digital Control Library, one DCL_DF22 a section: b0, b1, b2, a1, a2. */
{%- for axis in axes %}
static const float {{ name }}_dcl_{{ axis.name }}[{{ axis.count }}][5] = {
{%- for section in axis.dcl %}
    { {{ section }} },
{%- endfor %}
};
{%- endfor %}

#endif
