"""The laboratory: a gait under the hands of whoever sits at the browser.

Read in this order: `knobs` is what can be set, `outcome` what comes of it, `stage` draws the
scene's commands with viser, `panel` holds sliders and numbers, `session` joins them for one client,
`server` opens the page.
"""
