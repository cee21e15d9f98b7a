"""The HTTP service: validate, record, respond; no mathematics.

Floors, the highest first; each imports from lower ones alone ::

    openapi
    app
    server | api_document | routes
    bounded_connection
    runner
    answers
    models | middleware
    problems
    records
    settings
    logs | errors
"""
