"""Message classes from the text of a .proto file, without a compiler, in a pool of their own."""

import re

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

FIELD = descriptor_pb2.FieldDescriptorProto
SCALARS = {
    name: getattr(FIELD, f'TYPE_{name.upper()}') for name in ('double', 'uint32', 'uint64', 'bool')
}
LABELS = {
    name: getattr(FIELD, f'LABEL_{name.upper()}') for name in ('optional', 'required', 'repeated')
}
TOKEN = re.compile(r'"[^"]*"|[A-Za-z_][\w.]*|\d+|[{}=;]')


def classes(text):
    """Return the message classes of a proto2 text by name."""
    tokens = TOKEN.findall(re.sub(r'//[^\n]*', '', text))[::-1]
    file = descriptor_pb2.FileDescriptorProto(name='peer.proto', syntax='proto2')
    while tokens:
        word = tokens.pop()
        if word == 'package':
            file.package = tokens.pop()
            assert tokens.pop() == ';'
        elif word == 'syntax':
            assert [tokens.pop() for _ in range(3)] == ['=', '"proto2"', ';']
        else:
            assert word == 'message', word
            read_message(tokens, file.message_type.add(name=tokens.pop()), file.package)
    pool = descriptor_pool.DescriptorPool()
    pool.AddSerializedFile(file.SerializeToString())
    get = getattr(message_factory, 'GetMessageClass', None)
    get = get or message_factory.MessageFactory(pool).GetPrototype
    names = [message.name for message in file.message_type]
    return {name: get(pool.FindMessageTypeByName(f'{file.package}.{name}')) for name in names}


def read_message(tokens, message, package):
    enums = set()
    assert tokens.pop() == '{'
    while (word := tokens.pop()) != '}':
        if word == 'enum':
            enum = message.enum_type.add(name=tokens.pop())
            enums.add(enum.name)
            assert tokens.pop() == '{'
            while (name := tokens.pop()) != '}':
                assert tokens.pop() == '='
                enum.value.add(name=name, number=int(tokens.pop()))
                assert tokens.pop() == ';'
            continue
        kind, name, equals, number, end = (tokens.pop() for _ in range(5))
        assert (equals, end) == ('=', ';')
        field = message.field.add(name=name, number=int(number), label=LABELS[word])
        if kind in SCALARS:
            field.type = SCALARS[kind]
        elif kind in enums:
            field.type, field.type_name = FIELD.TYPE_ENUM, f'.{package}.{message.name}.{kind}'
        else:
            field.type, field.type_name = FIELD.TYPE_MESSAGE, f'.{package}.{kind}'
